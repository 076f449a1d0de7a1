#!/usr/bin/env bash
# Builds the playground, dist/playground.html: the programs in WebAssembly in
# one page that works without a network. Rust's target and the packages of
# web/ are fetched when they are not there.
set -euo pipefail
cd "$(dirname "$0")/.."
target=wasm32-wasip1
tools=target/playground-tools
rustup target list --installed | grep -qx $target || rustup target add $target
# Programs expect a stack of 8 MiB; here it is 1 MiB otherwise.
export CARGO_TARGET_WASM32_WASIP1_RUSTFLAGS="-C link-arg=-zstack-size=8388608"
cargo build --quiet --locked --profile playground --target $target --bin robovec
[ -d $tools/node_modules/esbuild ] || {
    mkdir -p $tools
    npm install --silent --no-audit --no-fund --no-save --prefix $tools \
        @bjorn3/browser_wasi_shim@0.4.2 esbuild@0.28.2
}
mkdir -p dist
node web/build.mjs target/$target/playground/robovec.wasm $tools dist/playground.html
