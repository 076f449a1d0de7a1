// Runs the programs: WebAssembly with arguments and a file system in memory.

import { WASI, Fd, File, Directory, OpenFile, PreopenDirectory, wasi } from "@bjorn3/browser_wasi_shim";

// What is written to a standard stream. A plain file, so that the programs
// show no progress and no colours.
class Collected extends Fd {
  parts = [];
  fd_fdstat_get() { return { ret: 0, fdstat: new wasi.Fdstat(wasi.FILETYPE_REGULAR_FILE, 0) }; }
  fd_filestat_get() { return { ret: 0, filestat: new wasi.Filestat(0n, wasi.FILETYPE_REGULAR_FILE, 0n) }; }
  fd_write(data) { this.parts.push(data.slice()); return { ret: 0, nwritten: data.byteLength }; }
  async text() { return new Blob(this.parts).text(); }
}

// All files of a folder by their paths.
function* filesOf(contents, prefix = "") {
  for (const [name, entry] of contents) {
    if (entry instanceof Directory) yield* filesOf(entry.contents, prefix + name + "/");
    else yield [prefix + name, entry];
  }
}

async function call(module, args, contents) {
  const known = new Set([...filesOf(contents)].map(([, file]) => file));
  const out = new Collected(), err = new Collected();
  const program = new WASI(args, [], [new OpenFile(new File([])), out, err, new PreopenDirectory(".", contents)], { debug: false });
  const start = performance.now();
  let status = null, trap = null;
  try {
    const instance = await WebAssembly.instantiate(module, { wasi_snapshot_preview1: program.wasiImport });
    status = program.start(instance);
  } catch (error) {
    trap = String(error.message ?? error);
  }
  const milliseconds = performance.now() - start;
  const decoder = new TextDecoder();
  const written = [...filesOf(contents)].filter(([, file]) => !known.has(file));
  return {
    status, trap, milliseconds, stdout: await out.text(), stderr: await err.text(),
    files: Object.fromEntries(written.map(([path, file]) => [path, decoder.decode(file.data)])),
  };
}

let contents = new Map();

onmessage = async ({ data: { id, module, files, args } }) => {
  if (files) {
    const encoder = new TextEncoder();
    contents = new Map(Object.entries(files).map(([name, text]) => [name, new File(encoder.encode(text))]));
  }
  postMessage({ id, ...await call(module, args, contents) });
};
