#!/usr/bin/env bash
# What is released: stripped programs, the wheel, and their sums, in dist/.
set -euo pipefail
cd "$(dirname "$0")/.."
mkdir -p dist
cargo build --release --quiet --locked --bins
version=$(cargo metadata --no-deps --format-version 1 --locked | sed 's/.*"name":"robovec","version":"\([^"]*\)".*/\1/')
name=robovec-$version-$(uname -m)-$(uname -s | tr '[:upper:]' '[:lower:]')
rm -rf "dist/$name" && mkdir "dist/$name"
for program in robovec robovec-opt; do
    strip -o "dist/$name/$program" "target/release/$program"
done
cp README.md CHANGELOG.md LICENSE-APACHE LICENSE-MIT "dist/$name"
tar -C dist -czf "dist/$name.tar.gz" "$name"
bash scripts/build-wheel.sh
(cd dist && sha256sum -- *.tar.gz *.whl | tee SHA256SUMS)
