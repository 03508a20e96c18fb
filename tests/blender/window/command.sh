#!/usr/bin/env bash
# Runs in Debian 13 (tools/blender_window shell): the command line inside Blender's own program. Arguments: the folder
# that holds penumbra.zip and wall.blend, and gets NAME.txt and NAME.code of every step.
cd "$1"
here=$PWD
small=(--size 64x36 --techniques shadow_map --lights Key --reference-error 0.1)

step() {
    local name=$1
    shift
    (cd /tmp && "$@") >"$name.txt" 2>&1
    echo $? >"$name.code"
}

penumbra() {
    blender --background "$here/wall.blend" --command penumbra "$@"
}

step install blender --background --command extension install-file -r user_default -e "$here/penumbra.zip"
step version penumbra --version
step wrong penumbra compare --out /tmp/wrong --techniques shadw
step compare penumbra compare --out "$here/compare" "${small[@]}"
step gate penumbra compare --out /tmp/gate "${small[@]}" --fail-rmse 0.01
step render penumbra render --technique pcf --size 64x36 --out "$here/picture.exr"
step batch penumbra batch --frames 1-3 --workers 2 --out "$here/batch" "${small[@]}"
step again penumbra batch --frames 1-3 --workers 2 --out "$here/batch" "${small[@]}"
export PENUMBRA_TEST_CRASH=wall/0001
step crash penumbra batch --frames 1-2 --out "$here/crash" "${small[@]}"
unset PENUMBRA_TEST_CRASH

# Ctrl-C, when a first item is done.
(cd /tmp && exec blender --background "$here/wall.blend" --command penumbra batch --frames 1-50 --out "$here/stopped" "${small[@]}") \
    >interrupt.txt 2>&1 &
for ((i = 0; i < 600; ++i)); do
    compgen -G "stopped/wall/*/item.json" >/dev/null && break
    sleep 0.1
done
kill -INT $!
wait $!
echo $? >interrupt.code
sleep 0.5
# No process but those of this shell: the workers are gone.
for process in /proc/[0-9]*; do
    tr '\0' ' ' <"$process/cmdline" 2>/dev/null | grep -q '^blender' && echo "$process"
done >left.txt
step disable blender --background --python-expr "
import addon_utils, sys
addon_utils.disable('bl_ext.user_default.penumbra')"
exit 0
