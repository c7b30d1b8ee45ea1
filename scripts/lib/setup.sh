# Sourced by scripts/run, scripts/test and .ci/run: finds Python, makes the virtual environment, looks for OpenGL.
# Set-up is done once; later runs find the stamp and go straight on.

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
venv="$root/.venv"
python="$venv/bin/python"
unset PYTHONHOME PYTHONPATH
export PYTHONNOUSERSITE=1 PIP_DISABLE_PIP_VERSION_CHECK=1

say() { printf '%s\n' "$*" >&2; }
fail() { say "camgeom set-up: $*"; exit 2; }
can_apt() { [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; }
apt_install() {
  export DEBIAN_FRONTEND=noninteractive
  { apt-get install -y --no-install-recommends "$@" || { apt-get update && apt-get install -y --no-install-recommends "$@"; }; } >&2
}

# A Python of at least 3.11: the system's own where it is new enough, else the newest named one.
find_python() {
  local name
  for name in python3 python3.13 python3.12 python3.11 python3.14 python; do
    if "$name" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
      "$name" -c 'import sys; print(sys.executable)'
      return 0
    fi
  done
  return 1
}

make_venv() {
  local base version package
  base="$(find_python)" || fail "no Python 3.11 or newer on the PATH (found: $(python3 --version 2>&1 || true)); on Debian 12+ or Ubuntu 24.04+: apt-get install python3 python3-venv"
  if ! "$base" -c 'import venv, ensurepip' 2>/dev/null; then
    version="$("$base" -c 'import sys; print("python%d.%d" % sys.version_info[:2])')"
    package="$version-venv"
    can_apt || fail "$base has no venv module; as root: apt-get install $package"
    say "camgeom set-up: installing $package"
    apt_install "$package" || fail "apt-get could not install $package, which $base needs to make a virtual environment"
  fi
  say "camgeom set-up: making ${venv##*/} with $("$base" --version) ($base)"
  rm -rf "$venv"
  "$base" -m venv "$venv" || fail "could not make $venv"
}

# What the environment was made from: the project file, this script, its place on the disk and the extra that was asked for.
stamp_text() { { cat "$root/pyproject.toml" "$root/scripts/lib/setup.sh"; printf '%s' "$root"; } | sha256sum | cut -c1-64; }
is_ready() {
  local stamp
  [ -x "$python" ] || return 1
  stamp="$(stamp_text)"
  [ "$(cat "$venv/.stamp-dev" 2>/dev/null)" = "$stamp" ] && return 0
  [ -z "$1" ] && [ "$(cat "$venv/.stamp" 2>/dev/null)" = "$stamp" ]
}

# ensure_venv [dev]: the environment with camgeom installed in place, and the development tools if asked for.
# The project file itself is the lock, so that two runs at once make one environment.
ensure_venv() {
  local extra="${1:-}" what="$root[full]"
  is_ready "$extra" && return 0
  exec 9<"$root/pyproject.toml"
  flock -n 9 || { say "camgeom set-up: waiting for another set-up of this folder"; flock 9; }
  if ! is_ready "$extra"; then
    "$python" -c 'import pip' 2>/dev/null || make_venv
    rm -f "$venv/.stamp" "$venv/.stamp-dev"
    [ -n "$extra" ] && what="$root[$extra]"
    say "camgeom set-up: installing camgeom${extra:+ with the $extra tools} into .venv (once; a minute or two)"
    "$python" -m pip install --quiet --editable "$what" >&2 ||
      fail "pip could not install the packages above; the first set-up needs a package index (PIP_INDEX_URL chooses another)"
    # pip compiles what it installs, but not what it installs in place: a command would compile it in every process
    # where the environment says that Python shall write no bytecode.
    "$python" -m compileall -q "$root/camgeom" >&2 || say "camgeom set-up: the package could not be compiled; it runs as it is"
    stamp_text >"$venv/.stamp${extra:+-$extra}"
  fi
  exec 9<&-
}

# Pictures need a software OpenGL; everything else works without it, so its absence is told and not fatal.
opengl_present() {
  local file
  for file in /usr/lib/*/libEGL.so.1 /usr/lib64/libEGL.so.1 /usr/lib/libEGL.so.1; do
    if [ -e "$file" ]; then
      for file in /usr/lib/*/dri/*_dri.so /usr/lib64/dri/*_dri.so /usr/lib/dri/*_dri.so /usr/lib/*/libgallium*.so; do
        [ -e "$file" ] && return 0
      done
    fi
  done
  return 1
}
ensure_opengl() {
  opengl_present && return 0
  if can_apt && [ ! -e "$venv/.opengl-tried" ]; then
    touch "$venv/.opengl-tried"
    say "camgeom set-up: installing the software OpenGL libraries libegl1 and libgl1-mesa-dri"
    apt_install libegl1 libgl1-mesa-dri && return 0
  fi
  say "camgeom: no OpenGL library found, so there will be no pictures; everything else works."
  say "         On Debian or Ubuntu, as root: apt-get install libegl1 libgl1-mesa-dri"
}
