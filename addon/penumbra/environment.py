"""The machine and the versions a comparison was measured on."""

from __future__ import annotations

import datetime
import os
import platform
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any


def collect(core: Any, renderer: Any | None, arguments: list[str]) -> dict[str, Any]:
    """Everything that can move a time or an error figure; absent facts are empty strings."""
    build = dict(core.build_info())
    document: dict[str, Any] = {
        "penumbra": core.__version__,
        "commit": str(build.get("commit", "")) or commit_of_checkout(),
        "build": build,
        "cpu": cpu_model(),
        "cores": usable_cores(),
        "memory_bytes": memory_bytes(),
        "os": operating_system(),
        "python": platform.python_version(),
        "blender": blender_version(),
        "date": datetime.datetime.now().astimezone().isoformat(timespec="seconds"),
        "command": shlex.join(["penumbra", *arguments]),
    }
    if renderer is not None:
        document |= dict(renderer.environment)
    return document


def commit_of_checkout() -> str:
    """The commit of the checkout this package runs from, "+" if it was changed since; empty for an installed one."""
    root = Path(__file__).resolve().parents[2]
    if not (root / "addon" / "penumbra").is_dir() or not (root / ".git").exists():
        return ""
    try:
        head = subprocess.run(
            ["git", "-C", str(root), "describe", "--always", "--abbrev=12", "--dirty=+", "--exclude=*"],
            capture_output=True, text=True, timeout=5, check=True,
        )  # fmt: skip
    except (OSError, subprocess.SubprocessError):
        return ""
    return head.stdout.strip()


def cpu_model() -> str:
    """ "AMD EPYC 7B13", or what the platform module knows."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def usable_cores() -> int:
    """Logical processors that this process may run on."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:
        return os.cpu_count() or 1


def memory_bytes() -> int:
    """Main memory of the machine; 0 if unknown."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return 0


def operating_system() -> str:
    """ "Debian GNU/Linux 12 (bookworm), Linux 6.1.0"."""
    kernel = f"{platform.system()} {platform.release()}"
    try:
        return f"{platform.freedesktop_os_release()['PRETTY_NAME']}, {kernel}"
    except (OSError, KeyError, AttributeError):
        return kernel


def blender_version() -> str:
    """Of the Blender in this process; empty if none was loaded. Never loads it."""
    bpy = sys.modules.get("bpy")
    return str(bpy.app.version_string) if bpy is not None else ""
