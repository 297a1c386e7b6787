// Checks GLB files with Khronos' validator: prints its errors and warnings, one a line after the file's name; exit code 1
// when there is an error.
const fs = require("fs");
const validator = require("gltf-validator");

const ERROR = 0;
const WARNING = 1;

async function main(files) {
  for (const file of files) {
    const { issues } = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), { maxIssues: 50 });
    for (const { severity, code, pointer, message } of issues.messages) {
      if (severity > WARNING) continue;
      console.log(`${file}: ${severity === ERROR ? "error" : "warning"} ${code} at ${pointer}: ${message}`);
      if (severity === ERROR) process.exitCode = 1;
    }
  }
}

main(process.argv.slice(2));
