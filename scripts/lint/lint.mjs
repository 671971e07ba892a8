// node lint.mjs ROOT FILE...: ruff on Python files, eslint on JavaScript ones. Prints file:line:column of
// every finding; exits with 1 where there is one.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { PositionEncoding, Workspace } from "@astral-sh/ruff-wasm-nodejs";
import { ESLint } from "eslint";
import { parse } from "smol-toml";

const [root, ...files] = process.argv.slice(2);
const is_page = (file) => /\.m?js$/.test(file);
let found = 0;
const tell = (file, line, column, text) => {
  console.log(`${file}:${line}:${column}: ${text}`);
  ++found;
};

const ruff = new Workspace(parse(readFileSync(join(root, "ruff.toml"), "utf8")), PositionEncoding.Utf32);
for (const file of files.filter((name) => !is_page(name))) {
  for (const { code, message, start_location: at } of ruff.check(readFileSync(join(root, file), "utf8"))) {
    tell(file, at.row, at.column, `${code} ${message}`);
  }
}

const eslint = new ESLint({ overrideConfigFile: join(import.meta.dirname ?? ".", "eslint.config.mjs") });
for (const file of files.filter(is_page)) {
  const [result] = await eslint.lintText(readFileSync(join(root, file), "utf8"), { filePath: "page.mjs" });
  for (const { line, column, ruleId, message } of result.messages) tell(file, line, column, `${ruleId} ${message}`);
}
process.exit(found ? 1 : 0);
