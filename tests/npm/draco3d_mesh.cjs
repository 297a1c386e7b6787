// Another program's Draco: PACKAGE encode IN.obj OUT.drc sequential|edgebreaker BITS, or PACKAGE decode IN.drc, by the npm
// package of that name. Vertices have positions, and a generic attribute that counts them. `decode` prints points, faces
// and the numbers as JSON. BITS 0: not quantised.
const fs = require("fs");
const path = require("path");

function parse(text) {
  const positions = [];
  const faces = [];
  for (const line of text.split("\n")) {
    const words = line.split(" ");
    if (words[0] === "v") positions.push(...words.slice(1, 4).map(Number));
    if (words[0] === "f") faces.push(...words.slice(1, 4).map((word) => parseInt(word, 10) - 1));
  }
  return { positions, faces };
}

function encode(draco, { positions, faces }, method, bits) {
  const encoder = new draco.Encoder();
  const builder = new draco.MeshBuilder();
  const mesh = new draco.Mesh();
  const points = positions.length / 3;
  builder.AddFacesToMesh(mesh, faces.length / 3, new Uint32Array(faces));
  builder.AddFloatAttributeToMesh(mesh, draco.POSITION, points, 3, new Float32Array(positions));
  builder.AddInt32AttributeToMesh(mesh, draco.GENERIC, points, 1, Int32Array.from({ length: points }, (_, at) => at));
  encoder.SetEncodingMethod(method === "sequential" ? draco.MESH_SEQUENTIAL_ENCODING : draco.MESH_EDGEBREAKER_ENCODING);
  encoder.SetSpeedOptions(5, 5);
  if (bits > 0) encoder.SetAttributeQuantization(draco.POSITION, bits);
  const out = new draco.DracoInt8Array();
  const length = encoder.EncodeMeshToDracoBuffer(mesh, out);
  if (length <= 0) throw new Error("nothing was encoded");
  return Buffer.from(Int8Array.from({ length }, (_, at) => out.GetValue(at)).buffer);
}

function values(draco, decoder, mesh, attribute, read, array) {
  read.call(decoder, mesh, attribute, array);
  return Array.from({ length: array.size() }, (_, at) => array.GetValue(at));
}

function decode(draco, bytes) {
  const decoder = new draco.Decoder();
  const buffer = new draco.DecoderBuffer();
  buffer.Init(new Int8Array(bytes), bytes.length);
  if (decoder.GetEncodedGeometryType(buffer) !== draco.TRIANGULAR_MESH) throw new Error("no triangle mesh");
  const mesh = new draco.Mesh();
  const status = decoder.DecodeBufferToMesh(buffer, mesh);
  if (!status.ok()) throw new Error(status.error_msg());
  const position = decoder.GetAttribute(mesh, decoder.GetAttributeId(mesh, draco.POSITION));
  const number = decoder.GetAttribute(mesh, decoder.GetAttributeId(mesh, draco.GENERIC));
  const faces = [];
  const corner = new draco.DracoInt32Array();
  for (let face = 0; face < mesh.num_faces(); ++face) {
    decoder.GetFaceFromMesh(mesh, face, corner);
    faces.push([0, 1, 2].map((at) => corner.GetValue(at)));
  }
  return {
    points: values(draco, decoder, mesh, position, decoder.GetAttributeFloatForAllPoints, new draco.DracoFloat32Array()),
    numbers: values(draco, decoder, mesh, number, decoder.GetAttributeInt32ForAllPoints, new draco.DracoInt32Array()),
    faces,
  };
}

// Given its binary, for 1.4 would fetch it as a page does; 1.3 has none. Older versions are thenables that resolve to themselves, which
// no promise survives.
function load(factory, name, binary) {
  const file = path.join(path.dirname(require.resolve(`${name}/package.json`)), binary);
  const options = fs.existsSync(file) ? { wasmBinary: fs.readFileSync(file) } : {};
  return new Promise((resolve) => factory(options).then((draco) => resolve({ ...draco, then: undefined })));
}

async function main([name, what, from, to, method, bits]) {
  const library = require(name);
  if (what === "encode") {
    const draco = await load(library.createEncoderModule, name, "draco_encoder.wasm");
    fs.writeFileSync(to, encode(draco, parse(fs.readFileSync(from, "utf8")), method, Number(bits)));
  } else {
    const draco = await load(library.createDecoderModule, name, "draco_decoder.wasm");
    console.log(JSON.stringify(decode(draco, fs.readFileSync(from))));
  }
}

main(process.argv.slice(2));
