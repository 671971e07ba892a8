// Bundles the page into one file: node build.mjs FOLDER OUTPUT, where FOLDER is that of the page's
// sources. `carillon report` puts what it shows in place of the mark in it. Runs where
// node_modules is, which need not be beside the sources.
import { build } from "esbuild";
import { readFile, writeFile } from "node:fs/promises";
import path from "node:path";

const [folder, output] = process.argv.slice(2);
if (!output) throw new Error("usage: node build.mjs FOLDER OUTPUT");

async function bundle(entry) {
  const result = await build({
    bundle: true,
    charset: "utf8",
    entryPoints: [path.join(folder, entry)],
    format: "iife",
    legalComments: "inline",
    minify: true,
    nodePaths: [path.resolve("node_modules")],
    target: "es2020",
    write: false,
  });
  // Nothing in it may end the element that holds it.
  return result.outputFiles[0].text.replaceAll("</script", "<\\/script").replaceAll("</style", "<\\/style");
}

const [script, style, frame] = await Promise.all([
  bundle("main.js"),
  bundle("style.css"),
  readFile(path.join(folder, "frame.html"), "utf8"),
]);
// Functions, as texts would have their dollar signs read.
await writeFile(output, frame.replace("/* style */", () => style).replace("/* script */", () => script));
