// Smooths a mesh as a web developer would: ADDRESS unary|stream OPTIONS MESH OUT, the options being SmoothOptions as
// JSON. With BURNISH_TOKEN in the environment it shows that token. Prints the report as JSON; when the call fails, its code, ErrorInfo reason and message on standard error.
const fs = require("fs");
const path = require("path");
const { Readable } = require("stream");
const grpc = require("@grpc/grpc-js");
const protoLoader = require("@grpc/proto-loader");

const CHUNK_BYTES = 256 * 1024;
const definition = protoLoader.loadSync(
  ["burnish/v1/smoothing.proto", "google/rpc/status.proto", "google/rpc/error_details.proto"],
  {
    includeDirs: [path.join(__dirname, "..", "..", "proto"), process.env.GOOGLE_RPC_PROTO_DIR],
    longs: Number,
    enums: String,
    defaults: true,
  },
);

const credentials = new grpc.Metadata();
if (process.env.BURNISH_TOKEN) credentials.set("authorization", `Bearer ${process.env.BURNISH_TOKEN}`);

function unary(client, mesh, options) {
  return new Promise((resolve, reject) => {
    client.smooth({ mesh, options }, credentials, (error, response) => (error ? reject(error) : resolve(response)));
  });
}

async function stream(client, mesh, options) {
  function* parts() {
    yield { start: { options, meshBytes: mesh.length } };
    for (let at = 0; at < mesh.length; at += CHUNK_BYTES) yield { meshChunk: mesh.subarray(at, at + CHUNK_BYTES) };
  }
  const call = client.smoothStream(credentials);
  Readable.from(parts()).pipe(call);
  const chunks = [];
  let report;
  for await (const part of call) {
    if (part.meshChunk) chunks.push(part.meshChunk);
    if (part.report) report = part.report;
  }
  return { mesh: Buffer.concat(chunks), report };
}

function errorInfo(error) {
  const [bytes] = error.metadata?.get("grpc-status-details-bin") ?? [];
  if (!bytes) return undefined;
  const { details } = definition["google.rpc.Status"].deserialize(bytes);
  const info = details.find((detail) => detail.type_url.endsWith("/google.rpc.ErrorInfo"));
  return info && definition["google.rpc.ErrorInfo"].deserialize(info.value);
}

async function main([address, way, options, meshFile, outFile]) {
  const { SmoothingService } = grpc.loadPackageDefinition(definition).burnish.v1;
  const client = new SmoothingService(address, grpc.credentials.createInsecure());
  try {
    const smooth = { unary, stream }[way];
    const { mesh, report } = await smooth(client, fs.readFileSync(meshFile), JSON.parse(options));
    fs.writeFileSync(outFile, mesh);
    console.log(JSON.stringify(report));
  } catch (error) {
    const code = grpc.status[error.code];
    if (!code) throw error;
    console.error(JSON.stringify({ code, reason: errorInfo(error)?.reason, message: error.details }));
    process.exitCode = 1;
  } finally {
    client.close();
  }
}

main(process.argv.slice(2));
