import { queryOf } from '../api/jobs';
import type { Options, Value } from '../api/types';

/** What was just done, told to a program. */
export interface Call {
  server: string;
  grpc: string;
  mesh: string;
  reference?: string;
  result: string;
  options: Options;
  /** Format of the result when it is not that of the mesh. */
  output?: string;
  token: boolean;
}

export type Language = 'curl' | 'cpp' | 'python';

export function callIn(language: Language, call: Call): string {
  return { curl, cpp, python }[language](call);
}

const shell = (text: string) => (/^[\w./:=@-]+$/.test(text) ? text : `'${text.replaceAll("'", `'\\''`)}'`);
const quoted = (text: string) => JSON.stringify(text);
const isNumber = (value: Value): value is number => typeof value === 'number';

function optionsJson({ options, output }: Call): string {
  return JSON.stringify({
    method: options.method,
    ...(Object.keys(options.parameters).length ? { parameters: options.parameters } : {}),
    ...(output ? { output: { format: output } } : {}),
  });
}

function curl(call: Call): string {
  const lines = ['curl --fail-with-body'];
  if (call.token) lines.push(`-H "Authorization: Bearer $BURNISH_TOKEN"`);
  if (call.reference) {
    lines.push(`-F ${shell(`mesh=@${call.mesh}`)}`, `-F ${shell(`reference=@${call.reference}`)}`, `-F ${shell(`options=${optionsJson(call)}`)}`);
    lines.push(shell(`${call.server}/v1/smooth`));
  } else {
    lines.push(`--data-binary ${shell(`@${call.mesh}`)}`, shell(`${call.server}/v1/smooth?${queryOf(call.options, call.output)}`));
  }
  lines.push(`-o ${shell(call.result)}`);
  return lines.join(' \\\n  ') + '\n';
}

const FORMATS: Record<string, string> = { obj: 'OBJ', drc: 'DRACO', ply: 'PLY', stl: 'STL', off: 'OFF', glb: 'GLB' };

function cpp(call: Call): string {
  const { options, output, reference } = call;
  const set = Object.entries(options.parameters).map(([name, value]) =>
    `  parameters[${quoted(name)}].${isNumber(value) ? `set_number_value(${value})` : `set_string_value(${quoted(value)})`};`);
  return [
    ...(call.token ? ['#include <cstdlib>'] : []), '#include <fstream>', '#include <iostream>', '#include <iterator>', '#include <string>', '', '#include "client/smoothing_client.h"', '',
    'std::string read(const char* path) {', '  std::ifstream file(path, std::ios::binary);',
    '  return {std::istreambuf_iterator<char>(file), {}};', '}', '',
    'int main() {', `  burnish::client::SmoothingClient client(${quoted(call.grpc)});`,
    '  burnish::v1::SmoothRequest request;', `  request.set_mesh(read(${quoted(call.mesh)}));`,
    ...(reference ? [`  request.set_reference(read(${quoted(reference)}));`] : []),
    `  request.mutable_options()->set_method(${quoted(options.method)});`,
    ...(set.length ? ['  auto& parameters = *request.mutable_options()->mutable_parameters();', ...set] : []),
    ...(output ? [`  request.mutable_options()->mutable_output()->set_format(burnish::v1::MESH_FORMAT_${FORMATS[output]});`] : []),
    '  const auto result = client.smooth(request' + (call.token ? ', {.token = std::getenv("BURNISH_TOKEN")});' : ');'),
    '  if (!result) {', '    std::cerr << result.error().message << "\\n";', '    return 1;', '  }',
    `  std::ofstream(${quoted(call.result)}, std::ios::binary) << result.value().mesh();`, '}', '',
  ].join('\n');
}

function python(call: Call): string {
  const { server, mesh, reference, result } = call;
  const header = call.token ? ', headers={"Authorization": "Bearer " + os.environ["BURNISH_TOKEN"]}' : '';
  const query = Object.fromEntries(queryOf(call.options, call.output));
  const lines = [...(call.token ? ['import os'] : []), 'import requests', ''];
  if (reference) {
    lines.push(`with open(${quoted(mesh)}, "rb") as mesh, open(${quoted(reference)}, "rb") as reference:`,
      `    answer = requests.post(${quoted(`${server}/v1/smooth`)}${header},`,
      `                           files={"mesh": mesh, "reference": reference, "options": (None, '${optionsJson(call)}')})`);
  } else {
    lines.push(`with open(${quoted(mesh)}, "rb") as mesh:`,
      `    answer = requests.post(${quoted(`${server}/v1/smooth`)}, data=mesh${header},`,
      `                           params=${JSON.stringify(query).replaceAll('":"', '": "').replaceAll('","', '", "')})`);
  }
  return [...lines, 'if not answer.ok:', '    raise SystemExit(answer.json()["detail"])', `with open(${quoted(result)}, "wb") as file:`,
    '    file.write(answer.content)', ''].join('\n');
}
