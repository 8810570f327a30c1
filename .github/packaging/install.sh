#!/bin/sh
# Installs the program for the current user: sh install.sh [FOLDER], by default ~/.local/bin. Nothing else is changed.
# REVOLVE_RELEASES is the address of the releases; the published copy of this file has it.
set -eu
releases=${REVOLVE_RELEASES:-@RELEASES@}
folder=${1:-$HOME/.local/bin}
machine=$(uname -m)
[ "$machine" != arm64 ] || machine=aarch64
case "$(uname -s)" in
    Linux)
        target=$machine-unknown-linux-gnu
        # A system without the GNU C library, or with one before 2.28, takes the static program (without compiled subroutines).
        version=$(getconf GNU_LIBC_VERSION 2>/dev/null | cut -d' ' -f2) || version=
        oldest=$(printf '%s\n2.28\n' "${version:-0}" | sort -V | head -n 1)
        [ "$oldest" = 2.28 ] || target=$machine-unknown-linux-musl
        ;;
    Darwin) target=$machine-apple-darwin ;;
    *)
        echo "install.sh: no archive for $(uname -s); on Windows unpack revolve-x86_64-pc-windows-msvc.tgz" >&2
        exit 1
        ;;
esac
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
for file in "revolve-$target.tgz" "revolve-$target.tgz.sha256"; do
    curl --proto '=https,file' -fsSL -o "$file" "$releases/latest/download/$file"
done
if command -v sha256sum >/dev/null; then sha256sum -c "revolve-$target.tgz.sha256"; else shasum -a 256 -c "revolve-$target.tgz.sha256"; fi
tar -xzf "revolve-$target.tgz"
mkdir -p "$folder"
mv revolve "$folder/revolve"
"$folder/revolve" --version
