#!/usr/bin/env bash
# Makes what is released, in dist/: an archive of stripped programs, manual
# pages, completions, documents, examples and licences; the wheel; their sums.
# scripts/test-release.sh tests them.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release --quiet --locked --bins
programs=target/release
version=$(cargo metadata --no-deps --format-version 1 --locked | sed 's/.*"name":"robovec","version":"\([^"]*\)".*/\1/')
name=robovec-$version-$(uname -m)-$(uname -s | tr '[:upper:]' '[:lower:]')
to=dist/$name
rm -rf "$to"
mkdir -p "$to"/bin "$to"/share/{man/man1,bash-completion/completions,zsh/site-functions,fish/vendor_completions.d,doc/robovec}

# Called by its name, `robovec` is `robovec-opt` as well.
strip -o "$to/bin/robovec" $programs/robovec
ln -s robovec "$to/bin/robovec-opt"
$programs/robovec manual --quiet -o "$to/share/man/man1" >/dev/null
# SHELL PROGRAM: the script that completes its command lines.
completion() {
    if [ "$2" = robovec ]; then $programs/robovec completion "$1"; else $programs/robovec-opt --completion "$1"; fi
}
for program in robovec robovec-opt; do
    completion bash $program >"$to/share/bash-completion/completions/$program"
    completion zsh $program >"$to/share/zsh/site-functions/_$program"
    completion fish $program >"$to/share/fish/vendor_completions.d/$program.fish"
done
doc=$to/share/doc/robovec
cp -r README.md CHANGELOG.md LICENSE-APACHE LICENSE-MIT docs examples "$doc"
scripts/third-party-licences robovec >"$doc/THIRD-PARTY.txt"

tar -C dist --owner=0 --group=0 --sort=name -czf "$to.tar.gz" "$name"
rm -r "$to"
bash scripts/build-wheel.sh
(cd dist && sha256sum -- robovec-*.tar.gz robovec-*.whl | tee SHA256SUMS)
