// Writes the built page as C++: node embed.mjs FOLDER SOURCE. Every file is compressed here, once.
import { createHash } from 'node:crypto';
import { readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { extname, join, relative, sep } from 'node:path';
import { gzipSync } from 'node:zlib';

const [folder, source] = process.argv.slice(2);
const types = {
  '.html': 'text/html; charset=utf-8',
  '.js': 'text/javascript; charset=utf-8',
  '.css': 'text/css; charset=utf-8',
  '.svg': 'image/svg+xml',
  '.wasm': 'application/wasm',
};

function filesIn(place) {
  return readdirSync(place, { withFileTypes: true }).flatMap((entry) => {
    const path = join(place, entry.name);
    return entry.isDirectory() ? filesIn(path) : [path];
  }).sort();
}

/** A C++ string literal; octal escapes end after three digits, so no digit that follows can join them. */
function literal(bytes) {
  const lines = [];
  for (let at = 0; at < bytes.length; at += 64) {
    let line = '';
    for (const byte of bytes.subarray(at, at + 64)) line += '\\' + byte.toString(8).padStart(3, '0');
    lines.push(`    "${line}"`);
  }
  return lines.join('\n');
}

const entries = filesIn(folder).map((path) => {
  const name = relative(folder, path).split(sep).join('/');
  const type = types[extname(name)];
  if (!type) throw new Error(`no media type for ${name}`);
  const content = readFileSync(path);
  const packed = gzipSync(content, { level: 9 });
  const hash = createHash('sha256').update(content).digest('hex').slice(0, 16);
  const place = name === 'index.html' ? '/' : `/${name}`;
  return { packed, text: `    {"${place}", "${type}", "${hash}", {kFile@, ${packed.length}}, ${content.length}},` };
});
const text = `// Written by client/web/embed.mjs.
#include "server/http/page.h"

namespace {

${entries.map(({ packed }, i) => `constexpr char kFile${i}[] =\n${literal(packed)};`).join('\n')}

constexpr burnish::PageFile kFiles[] = {
${entries.map(({ text: line }, i) => line.replace('@', String(i))).join('\n')}
};

}  // namespace

std::span<const burnish::PageFile> burnish::page_files() { return kFiles; }
`;
writeFileSync(source, text);
