// Lints the OpenAPI document on standard input with every recommended rule as an error. Prints what it finds; exit code
// 1 when there is anything.
const { createConfig, lintFromString } = require("@redocly/openapi-core");

async function main() {
  const chunks = [];
  for await (const chunk of process.stdin) chunks.push(chunk);
  const problems = await lintFromString({
    source: Buffer.concat(chunks).toString("utf8"),
    absoluteRef: "openapi.json",
    config: await createConfig({ extends: ["recommended-strict"] }),
  });
  for (const { ruleId, message, location } of problems) {
    console.log(`${ruleId} at ${location.map((place) => place.pointer).join(", ")}: ${message}`);
  }
  process.exitCode = problems.length ? 1 : 0;
}

main();
