#!/bin/sh
# Rebuilds every asset and checks it. Python 3.11.
#   assets/make/make.sh              rebuild in place, then check
#   assets/make/make.sh --verify     rebuild elsewhere and compare to the byte, then check
#   assets/make/make.sh --suzanne    first export Suzanne anew from Blender (300 MB wheel)
# The virtual environment stands in $PRISM_ASSETS_VENV (default: under the temporary folder).
set -eu
here=$(cd "$(dirname "$0")" && pwd)
venv=${PRISM_ASSETS_VENV:-${TMPDIR:-/tmp}/prism-assets-venv}
export PYTHONDONTWRITEBYTECODE=1

install() { # folder, requirements
    [ -x "$1/bin/python" ] || "${PYTHON:-python3}" -m venv "$1"
    "$1/bin/python" -m pip install --quiet --disable-pip-version-check -r "$here/$2"
}

if [ "${1:-}" = "--suzanne" ]; then
    shift
    install "$venv-bpy" requirements-suzanne.txt
    "$venv-bpy/bin/python" "$here/suzanne_bpy.py"
fi
install "$venv" requirements.txt
"$venv/bin/python" "$here/make.py" "$@"
"$venv/bin/python" "$here/check.py"
