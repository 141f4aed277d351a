# What the other scripts share; sourced by them. Goes to the top of the project, reads --no-install and
# installs what is missing on a Debian machine that has only a Rust toolchain. Asks nothing.

root=$(CDPATH='' cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd -P)

# A relative target folder counts from where the caller stands, as it does for cargo.
case ${CARGO_TARGET_DIR-} in
    '' | /*) ;;
    *) export CARGO_TARGET_DIR=$PWD/$CARGO_TARGET_DIR ;;
esac
cd -- "$root"

# Where there is no session, Mesa's layer that picks a device for the desktop writes errors to standard error.
[ -n "${XDG_RUNTIME_DIR-}" ] || export NODEVICE_SELECT=1

no_install=

say() { printf '== %s\n' "$*"; }
fail() {
    printf '%s: %s\n' "scripts/${0##*/}" "$*" >&2
    exit 1
}

# need REASON PACKAGE...: installs Debian packages.
need() {
    local reason=$1 as_root=()
    shift
    [ -z "$no_install" ] || fail "$reason. With --no-install nothing is installed; run: apt-get install $*"
    command -v apt-get >/dev/null || fail "$reason, and there is no apt-get here; install what your system calls: $*"
    if [ "$(id -u)" -ne 0 ]; then
        sudo -n true 2>/dev/null || fail "$reason, and sudo would ask for a password; run as root: apt-get install $*"
        as_root=(sudo -n)
    fi
    say "$reason: installing $*"
    # ${x[@]+...}: an empty array counts as unset in old versions of bash.
    ${as_root[@]+"${as_root[@]}"} env DEBIAN_FRONTEND=noninteractive apt-get -qq update </dev/null
    ${as_root[@]+"${as_root[@]}"} env DEBIAN_FRONTEND=noninteractive \
        apt-get -qq install --yes --no-install-recommends "$@" </dev/null
}

need_toolchain() {
    if ! command -v cargo >/dev/null && [ -r "${CARGO_HOME:-$HOME/.cargo}/env" ]; then
        # shellcheck disable=SC1091
        . "${CARGO_HOME:-$HOME/.cargo}/env"
    fi
    command -v cargo >/dev/null || fail "there is no Rust toolchain; see https://rustup.rs"
    command -v cc >/dev/null || need "there is no linker" gcc libc6-dev
}

# need_component TOOL: a part of the toolchain that small installations leave out.
need_component() {
    cargo "$1" --version >/dev/null 2>&1 && return
    local component=$1
    [ "$component" = fmt ] && component=rustfmt
    [ -z "$no_install" ] || fail "cargo $1 is missing. With --no-install nothing is installed; run: rustup component add $component"
    command -v rustup >/dev/null || fail "cargo $1 is missing, and so is rustup; install $component"
    say "cargo $1 is missing: installing $component"
    rustup component add "$component"
}

# pellucid ARGUMENT...: the program, built with the flags in $profile. cargo passes its exit code on.
profile=()
pellucid() { cargo run --quiet ${profile[@]+"${profile[@]}"} --bin pellucid -- "$@"; }

# Installs the Vulkan loader and Mesa's software renderer if no adapter answers (exit code 4).
need_adapter() {
    local code=0
    pellucid adapters >/dev/null 2>&1 || code=$?
    if [ "$code" -eq 4 ]; then
        need "no graphics adapter answers" libvulkan1 mesa-vulkan-drivers
        code=0
        pellucid adapters >/dev/null || code=$?
    fi
    [ "$code" -eq 0 ] || fail "no graphics adapter can be used (pellucid adapters exits with $code)"
}

# A virtual display and hands for it, for the test of the real window. Linux only: elsewhere that test says it is skipped.
need_virtual_display() {
    [ "$(uname)" = Linux ] || return 0
    if ! command -v Xvfb >/dev/null || ! command -v xdotool >/dev/null || ! command -v import >/dev/null; then
        need "there is no virtual display" xvfb xdotool imagemagick libxkbcommon-x11-0 libxcursor1 libxi6
    fi
}

# render_demo FILE: a real assembly, through the importer, to a picture.
render_demo() {
    mkdir -p "$(dirname -- "$1")"
    pellucid render assets/gearbox.glb -o "$1"
}
