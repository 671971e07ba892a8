// Bundles the page into one file: node build.mjs FOLDER OUTPUT, where FOLDER is that of the page's
// sources. `carillon report` puts what it shows in place of the mark in it. Runs where
// node_modules is, which need not be beside the sources. licences.txt beside OUTPUT has those of the
// packages that are in it, and OUTPUT.hpp a hash of the page: caches of compilers know the source that
// includes it by what it reads as a source, and would give an older page.
import { build } from "esbuild";
import { createHash } from "node:crypto";
import { readdir, readFile, writeFile } from "node:fs/promises";
import path from "node:path";

const [folder, output] = process.argv.slice(2);
if (!output) throw new Error("usage: node build.mjs FOLDER OUTPUT");

const packages = new Set();

async function bundle(entry) {
  const result = await build({
    bundle: true,
    charset: "utf8",
    entryPoints: [path.join(folder, entry)],
    format: "iife",
    legalComments: "inline",
    metafile: true,
    minify: true,
    nodePaths: [path.resolve("node_modules")],
    target: "es2020",
    write: false,
  });
  for (const input of Object.keys(result.metafile.inputs)) {
    const found = /^.*node_modules\/(@[^/]+\/)?[^/]+/.exec(input);
    if (found) packages.add(found[0]);
  }
  // Nothing in it may end the element that holds it.
  return result.outputFiles[0].text.replaceAll("</script", "<\\/script").replaceAll("</style", "<\\/style");
}

// A package's licence is a file of its own or the last part of its README.
async function licence(folder) {
  const read = (file) => readFile(path.join(folder, file), "utf8");
  const { name, version } = JSON.parse(await read("package.json"));
  const file = (await readdir(folder)).find((file) => /^licen[cs]e/i.test(file));
  const text = file ? await read(file) : /^#+ licen[cs]e.*/ims.exec(await read("README.md"))?.[0];
  if (!text) throw new Error(`${folder}: no licence, so the page may not hold it`);
  return `${name} ${version}\n\n${text}`;
}

const [script, style, frame] = await Promise.all([
  bundle("main.js"),
  bundle("style.css"),
  readFile(path.join(folder, "frame.html"), "utf8"),
]);
// Functions, as texts would have their dollar signs read.
const page = frame.replace("/* style */", () => style).replace("/* script */", () => script);
await writeFile(output, page);
await writeFile(`${output}.hpp`, `#pragma once\n// ${createHash("sha256").update(page).digest("hex")}\n`);
const licences = await Promise.all([...packages].sort().map(licence));
await writeFile(path.join(path.dirname(output), "licences.txt"), licences.join("\n\n"));
