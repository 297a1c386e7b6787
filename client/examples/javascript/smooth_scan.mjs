// smooth_scan.mjs URL IN OUT: smooths a scan by one fetch, as a page would, and tells what was done.
import { readFile, writeFile } from "node:fs/promises";

const TIMEOUT_MS = 120_000;

// The mesh, as ArrayBuffer, and the report. Throws a sentence that names the place in the scan.
export async function smooth(url, scan, { token, options = {} } = {}) {
  const target = new URL("/v1/smooth", url);
  for (const [name, value] of Object.entries(options)) target.searchParams.set(name, value);
  const answer = await fetch(target, {
    method: "POST",
    body: scan,
    headers: token ? { Authorization: `Bearer ${token}` } : {},
    signal: AbortSignal.timeout(TIMEOUT_MS),
  });
  if (!answer.ok) {
    const { code, detail } = await answer.json();
    throw new Error(`${code}: ${detail}`);
  }
  return { mesh: await answer.arrayBuffer(), report: JSON.parse(answer.headers.get("Burnish-Report")) };
}

async function main([url, scan, out]) {
  const { mesh, report } = await smooth(url, await readFile(scan), { token: process.env.BURNISH_TOKEN });
  await writeFile(out, new Uint8Array(mesh));
  console.log(
    `${report.method}: ${report.input.triangles} triangles with noise of ${report.noise.sigmaOverEdge.toPrecision(3)} mean edges, ` +
      `moved by ${report.change.maxDisplacement.toPrecision(3)} at most, in ${report.timings.totalMs.toFixed(1)} ms`,
  );
}

main(process.argv.slice(2)).catch((error) => {
  console.error(error.message);
  process.exitCode = 1;
});
