# Sourced by ./demo, ./test and tools/build_wheel: system packages, the virtual environment .venv, the installed project.
# Everything is kept between runs and shared by the scripts, so only the first run takes long.

set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
VENV="${PENUMBRA_VENV:-$PWD/.venv}"
# One cache for all build folders of this checkout.
export CCACHE_BASEDIR="$PWD" CCACHE_NOHASHDIR=1
export PIP_DISABLE_PIP_VERSION_CHECK=1

say() { printf '\n\033[1m== %s\033[0m\n' "$*"; }
fail() {
    printf 'error: %s\n' "$*" >&2
    exit 1
}

# What the build needs, then what runs need: software OpenGL, and the libraries that Blender as a module links.
BUILD_PACKAGES=(g++ git ccache libembree-dev libglm-dev libmeshoptimizer-dev libxxhash-dev)
RUN_PACKAGES=(libegl1 libgl1 libgl1-mesa-dri libx11-6 libxext6 libxrender1 libxfixes3 libxi6 libxxf86vm1 libxkbcommon0
    libsm6 libice6)
TEST_PACKAGES=(libgtest-dev libgmock-dev)

# need_packages NAME...: installs the Debian packages that are missing, or says which.
need_packages() {
    command -v dpkg-query >/dev/null || {
        echo "This system is not Debian: making sure of these is yours: $*" >&2
        return 0
    }
    local missing=() name
    for name in "$@"; do
        [[ $(dpkg-query -W -f '${db:Status-Status}' "$name" 2>/dev/null) == installed ]] || missing+=("$name")
    done
    ((${#missing[@]})) || return 0
    local as_root=()
    if ((EUID != 0)); then
        sudo -n true 2>/dev/null || [[ -t 0 ]] && command -v sudo >/dev/null ||
            fail "Debian packages are missing; run: sudo apt-get install ${missing[*]}"
        as_root=(sudo)
    fi
    say "Installing ${missing[*]}"
    "${as_root[@]}" apt-get update -qq || echo "apt-get update failed; trying with the lists at hand" >&2
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" ||
        fail "Debian packages could not be installed; run: sudo apt-get install ${missing[*]}"
}

# find_python [VERSION]: sets PYTHON to an interpreter of that version (3.11): $PYTHON itself, one on the path, or one that
# pyenv or uv keeps. Fails if there is none.
find_python() {
    local version=${1:-3.11} candidate
    local candidates=(${PYTHON:+"$PYTHON"} "python$version" python3)
    ! command -v pyenv >/dev/null || candidates+=("$(pyenv root)/versions/$version."*/bin/python)
    ! command -v uv >/dev/null || candidates+=("$(uv python find "$version" 2>/dev/null || true)")
    for candidate in "${candidates[@]}"; do
        if "$candidate" -c "import sys; sys.exit('%d.%d' % sys.version_info[:2] != '$version')" 2>/dev/null; then
            PYTHON="$candidate"
            return
        fi
    done
    return 1
}

# make_environment [VERSION]: the virtual environment $VENV with Python 3.11, or of the version given.
make_environment() {
    local version=${1:-3.11}
    [[ -x $VENV/bin/python ]] && "$VENV/bin/python" -c 'import pip' 2>/dev/null && return
    find_python "$version" ||
        fail "Python $version is needed (Blender's module is built for exactly that) and was not found; install it or set PYTHON"
    # Debian's own interpreter comes without ensurepip and headers.
    if ! "$PYTHON" -c 'import ensurepip, os, sysconfig, sys
sys.exit(not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")))' 2>/dev/null; then
        need_packages python3-venv python3-dev
    fi
    say "Making the virtual environment $VENV"
    "$PYTHON" -m venv "$VENV"
}

# install_project EXTRA,...: builds and installs the working tree. The build folder is kept and build isolation is off,
# so that a second run compiles only what changed.
install_project() {
    make_environment
    export PATH="$VENV/bin:$PATH" VIRTUAL_ENV="$VENV"
    local step=(python -m pip install --quiet)
    if ! python -c 'import glad, ninja, pybind11, scikit_build_core' 2>/dev/null || ! cmake --version >/dev/null 2>&1; then
        say "Installing the build tools"
        "${step[@]}" 'scikit-build-core>=1.1,<2' 'pybind11>=3.1,<4' 'glad2>=2.0.6,<3' 'jinja2>=3.1,<4' \
            'cmake>=3.25' 'ninja>=1.11' || fail "pip could not get the build tools; check the network and try again"
    fi
    say "Building and installing penumbra (extras: $1; the first time takes minutes)"
    "${step[@]}" --no-build-isolation --config-settings=build-dir=build/wheel ".[$1]" ||
        fail "building or installing penumbra did not work; what went wrong is above"
    local missing
    missing=$(ldd "$(python -c 'import importlib.util as u; print(u.find_spec("bpy").origin)')" |
        awk '/not found/ {print $1}' | tr '\n' ' ')
    [[ -z $missing ]] || fail "Blender's module needs libraries that this system lacks: $missing"
}
