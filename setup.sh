#!/bin/sh
# Makes sure that this machine has what a task needs, then runs a command with Rust on its PATH:
#
#     ./setup.sh demo|test|check|bits|fuzz|memory [COMMAND [ARGUMENT...]]
#
# demo: what building and running needs; test: also what the tests need; check: also rustfmt and clippy; bits: also
# an emulator of other CPUs; fuzz: also a C++ compiler; memory: also valgrind.
# Says nothing and changes nothing when nothing is missing. Otherwise says what is missing and why, and installs it
# on Debian and Ubuntu; elsewhere it names what to install and fails.
set -eu
cd "$(dirname "$0")"

task=${1:-}
case $task in
    demo | test | check | bits | fuzz | memory) shift ;;
    *) echo "usage: ./setup.sh demo|test|check|bits|fuzz|memory [COMMAND [ARGUMENT...]]" >&2 && exit 2 ;;
esac

say() { echo "setup: $*" >&2; }
die() { say "$*" && exit 1; }
have() { command -v "$1" >/dev/null 2>&1; }
any() { # whether one of the files exists
    for file; do [ -e "$file" ] && return; done
    return 1
}
at_least() { # VERSION MINIMUM
    case $1 in [0-9]*.[0-9]*) [ "$(printf '%s\n' "$2" "$1" | sort -V | head -n 1)" = "$2" ] ;; *) false ;; esac
}

# --- what is missing ------------------------------------------------------------------------------------------------

rust_minimum=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)

# Sets `rust` to good, old (`rust_found` says which), idle (rustup has no toolchain) or none; puts it on the PATH.
find_rust() {
    rust=none rust_found="" original_path=$PATH
    # Off the PATH: where rustup installs, and where Ubuntu's versioned packages do.
    for directory in "" "${CARGO_HOME:-${HOME:-}/.cargo}/bin" /usr/lib/rust-*/bin; do
        PATH=${directory:+$directory:}$original_path
        if version=$(rustc --version 2>/dev/null) && cargo --version >/dev/null 2>&1; then
            version=${version#rustc } version=${version%% *}
            at_least "$version" "$rust_minimum" && rust=good && return
            rust=old rust_found="$version ($(command -v rustc))"
        elif [ $rust = none ] && have rustup; then
            rust=idle original_path=$PATH
        fi
    done
    PATH=$original_path
}

is_debian() { grep -qx 'ID=debian' /etc/os-release 2>/dev/null; }

need() { # REASON PACKAGE...
    reasons="$reasons
  $1"
    shift
    packages="$packages $*"
}

# An LCM of one's own takes the place of the system's; so does the one that unpack_lcm has put here.
unpacked=$PWD/target/lcm/usr
if [ -z "${LCM_PREFIX:-}" ] && [ -e "$unpacked/bin/lcm-gen" ]; then LCM_PREFIX=$unpacked && export LCM_PREFIX; fi

# Sets `packages` and `components` (of rustup) to what is missing, `reasons` to why it is needed.
examine() {
    packages="" components="" reasons=""
    if ! echo '#include <stdio.h>' | cc -E -x c - >/dev/null 2>&1; then
        need "a C compiler and its headers: LCM's generated code, linking" gcc libc6-dev
    fi
    have pkg-config || need "pkg-config: finds libraries" pkg-config
    pkg-config --exists glib-2.0 2>/dev/null || need "GLib's development files: the LCM library needs it" libglib2.0-dev
    if [ -z "${LCM_PREFIX:-}" ] && ! { have lcm-gen && any /usr/include/lcm/lcm.h /usr/local/include/lcm/lcm.h; }; then
        need "LCM: the library, and lcm-gen, which turns the message types into C" liblcm-dev liblcm-bin
    fi
    if ! any "${LIBCLANG_PATH:-/nowhere}"/libclang* /usr/lib/llvm-*/lib/libclang*.so* /usr/lib*/libclang*.so* \
        /opt/homebrew/opt/llvm/lib/libclang.dylib ||
        ! any /usr/lib/llvm-*/lib/clang/*/include/stddef.h /usr/lib*/clang/*/include/stddef.h \
            /opt/homebrew/opt/llvm/lib/clang/*/include/stddef.h; then
        need "libclang: bindgen reads LCM's headers with it" libclang-dev
    fi
    if have apt-get && ! any /etc/ssl/certs/ca-certificates.crt; then
        need "certificates: cargo and pip download over HTTPS" ca-certificates
    fi
    if [ "$task" != demo ] && [ "$task" != fuzz ]; then
        python3 -c 'import ensurepip, venv' 2>/dev/null ||
            need "Python with venv: the tests exchange messages with Python's LCM" python3 python3-venv
        have ip || need "ip: the tests run nodes in network namespaces" iproute2
        have javac || need "a Java compiler: a test asks lcm-spy's own database for our types" default-jdk-headless
        if ! any "${LCM_PREFIX:-/usr}"/share/java/lcm.jar /usr/share/java/lcm.jar ||
            ! any "${LCM_PREFIX:-/usr}"/share/java/jchart2d*.jar /usr/share/java/jchart2d*.jar; then
            need "lcm-spy, for that test" liblcm-java libjchart2d-java
        fi
        # Elsewhere a browser is a snap or from another source: that test is skipped there.
        if is_debian && ! { have chromium-headless-shell || have chromium; }; then
            need "a browser without a window: a test looks at the page of touchdown watch --web" chromium-headless-shell
        fi
    fi
    if [ "$task" = bits ]; then
        have qemu-x86_64 || need "qemu: runs a test as other CPUs do" qemu-user
    fi
    if [ "$task" = fuzz ]; then
        have c++ || need "a C++ compiler: libFuzzer" g++
    fi
    if [ "$task" = memory ]; then
        have valgrind || need "valgrind: watches what the C code does with memory" valgrind
    fi
    find_rust
    case $rust in
        none | idle) need "Rust $rust_minimum or newer: the language of Touchdown" ;;
        good) if [ "$task" = check ] && ! { cargo fmt --version && cargo clippy --version; } >/dev/null 2>&1; then
            need "rustfmt and clippy: form and lints of the source"
            if have rustup; then components="rustfmt clippy"; else packages="$packages $(lint_packages)"; fi
        fi ;;
    esac
}

# --- how to get it --------------------------------------------------------------------------------------------------

as_root() {
    if [ "$(id -u)" = 0 ]; then
        "$@"
    elif [ -t 0 ]; then
        sudo "$@" # somebody is there to type the password
    else
        sudo -n "$@"
    fi
}
apt() { as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300 "$@" >&2; }
candidate() { LC_ALL=C apt-cache policy "$1" 2>/dev/null | sed -n 's/^  Candidate: //p'; }

# The packages rustc*, cargo* that are new enough: the system's own, the ones that Debian keeps current for its
# browsers (-web), the versioned ones of Ubuntu, newest first.
rust_packages() {
    for suffix in "" -web $(apt-cache pkgnames cargo- | sed -n 's/^cargo\(-[0-9.]*\)$/\1/p' | sort -rV); do
        if at_least "$(candidate "rustc$suffix")" "$rust_minimum"; then
            echo "rustc$suffix cargo$suffix $([ "$task" != check ] || lint_packages "$suffix")"
            return
        fi
    done
    return 1
}
lint_packages() { # [SUFFIX], that of the installed rustc unless told
    suffix=${1-$(dpkg -S "$(readlink -f "$(command -v rustc)")" 2>/dev/null | sed -n 's/^rustc\(.*\): .*/\1/p')}
    echo "rustfmt$suffix $([ "$suffix" ] && echo "rust$suffix-clippy" || echo rust-clippy)"
}

# Sets `wanted` to the packages to install, `unpack` to those to unpack, `unknown` to what apt does not offer; fails
# if there is any of the latter.
resolve() {
    wanted="" unpack="" unknown=""
    for package in $packages; do
        case "$package $(candidate "$package")" in
            *" " | *" (none)") unknown="$unknown $package" ;;
            liblcm-dev | liblcm-bin) if wants_java; then unpack="$unpack $package"; else wanted="$wanted $package"; fi ;;
            *) wanted="$wanted $package" ;;
        esac
    done
    if [ $rust = none ]; then
        if found=$(rust_packages); then
            wanted="$wanted $found"
        else
            unknown="$unknown rustc and cargo ($rust_minimum or newer)"
        fi
    fi
    [ -z "$unknown" ]
}
wants_java() { LC_ALL=C apt-cache depends liblcm-bin | grep -q 'Depends: .*-jre'; } # as on Ubuntu, for lcm-spy

# shellcheck disable=SC2086 # lists of packages
install_packages() {
    updated=""
    update() {
        say "apt-get update"
        apt update && updated=yes
    }
    resolve || { may_install && update && resolve; } || true
    if [ "$wanted$unknown" ] && ! may_install; then
        die "needs root, and there is no sudo; as root, run apt-get update, then apt-get install$wanted$unknown"
    fi
    [ -z "$unknown" ] || die "apt's sources do not offer:$unknown; where to find them:
  Debian: Rust in the security updates (bookworm, trixie); Ubuntu: LCM and Rust in universe and the updates;
  Rust also at https://rustup.rs"
    if [ "$wanted" ]; then
        set -- install -y --no-install-recommends $wanted
        say "apt-get $*"
        apt "$@" || { [ -z "$updated" ] && update && apt "$@"; } || die "that failed; run it as root: apt-get $*"
    fi
    [ -z "$unpack" ] || unpack_lcm
}
may_install() { [ "$(id -u)" = 0 ] || have sudo; }

# LCM's packages without the Java runtime that they depend on.
# shellcheck disable=SC2086 # a list of packages
unpack_lcm() {
    say "unpacking$unpack in target/lcm: installing them would install Java"
    mkdir -p target/lcm
    (
        cd target/lcm
        apt-get -q -o APT::Sandbox::User=root download $unpack
        for deb in *.deb; do dpkg-deb -x "$deb" .; done
        rm ./*.deb
    ) >&2
    LCM_PREFIX=$unpacked && export LCM_PREFIX
}

elsewhere() { # what to do without apt-get
    system=$(uname -s)
    # shellcheck source=/dev/null
    if [ -r /etc/os-release ]; then system=$(. /etc/os-release && echo "$ID ${ID_LIKE:-}"); fi
    case $system in
        *fedora*) hint="sudo dnf install gcc pkgconf-pkg-config glib2-devel clang-devel python3 iproute rust cargo" ;;
        *arch*) hint="sudo pacman -S gcc pkgconf glib2 clang python iproute2 rust" ;;
        Darwin) hint="brew install pkgconf glib llvm python rust" ;;
        *) hint="a C compiler, pkg-config, GLib's headers, libclang, Python 3 with venv, iproute2, Rust" ;;
    esac
    die "installs by itself on Debian and Ubuntu only; here: $hint
  and LCM with lcm-gen: https://github.com/lcm-proj/lcm, or Python's package lcm with LCM_PREFIX set to it;
  Rust $rust_minimum or newer is also at https://rustup.rs"
}

# --- what happens ---------------------------------------------------------------------------------------------------

examine
if [ $rust = old ]; then
    if have rustup; then
        remedy="rustup update stable"
    elif have apt-get && remedy=$(rust_packages); then
        remedy="sudo apt-get install ${remedy% }"
    else
        remedy="see https://rustup.rs"
    fi
    die "Rust $rust_found is older than $rust_minimum, the minimum in Cargo.toml; update it: $remedy"
fi
if [ "$reasons" ]; then
    say "\`make $task\` needs what this machine lacks:$reasons"
    if [ "$packages" ] || [ $rust = none ]; then
        have apt-get || elsewhere
        install_packages
    fi
    if [ $rust = idle ]; then
        say "rustup toolchain install stable"
        rustup toolchain install stable --profile minimal --no-self-update >&2
        rustup default stable >&2
        [ "$task" != check ] || components="rustfmt clippy"
    fi
    if [ "$components" ]; then
        say "rustup component add $components"
        # shellcheck disable=SC2086 # a list of components
        rustup component add $components >&2
    fi
    examine
    [ -z "$reasons" ] || die "installed it all, yet this is still missing:$reasons"
    say "done"
fi

[ $# = 0 ] || exec "$@"
