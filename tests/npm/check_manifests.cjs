// Checks Kubernetes objects on standard input (YAML, one or more) against the schemas of the Kubernetes API. Prints what is
// wrong, by object and place, or else the name of each object; exit code 1 when anything is wrong.
const { loadAll } = require("js-yaml");

/// The data, and a list of the keys that nobody has read, by place.
function watched(data, place = "") {
  if (data === null || typeof data !== "object") return { data, unread: () => [] };
  const read = new Set();
  const children = {};
  for (const key of Object.keys(data)) children[key] = watched(data[key], `${place}/${key}`);
  const proxy = new Proxy(data, {
    get(target, key) {
      if (!Object.hasOwn(children, key)) return target[key];
      read.add(key);
      return children[key].data;
    },
  });
  const unread = () =>
    Object.entries(children).flatMap(([key, child]) => (read.has(key) ? child.unread() : [`${place}/${key}`]));
  return { data: proxy, unread };
}

function problems(object) {
  const [group, version] = object.apiVersion.includes("/") ? object.apiVersion.split("/") : [undefined, object.apiVersion];
  const known = ["", ".k8s.io"].map((end) => (group ? `${group}${end}/${version}` : version));
  let kinds;
  for (const name of known) {
    try {
      kinds ??= require(`kubernetes-models/${name}`);
    } catch (error) {
      if (!["MODULE_NOT_FOUND", "ERR_PACKAGE_PATH_NOT_EXPORTED"].includes(error.code)) throw error;
    }
  }
  const Kind = kinds?.[object.kind];
  if (!Kind) return [`${object.apiVersion} has no kind ${object.kind}`];
  const { data, unread } = watched(object);
  try {
    Kind.prototype.validate.call(data); // an instance would be a copy, of which nobody sees what is read
  } catch (error) {
    return [error.message];
  }
  return unread().map((place) => `${place} is no field of it`); // what the schema knows, its check has read
}

let text = "";
process.stdin.on("data", (chunk) => (text += chunk));
process.stdin.on("end", () => {
  const objects = loadAll(text).filter((object) => object !== null);
  for (const object of objects) {
    const name = `${object.kind} ${object.metadata?.name}`;
    const found = problems(object);
    for (const problem of found) console.log(`${name}: ${problem}`);
    if (found.length > 0) process.exitCode = 1;
    else console.log(name);
  }
});
