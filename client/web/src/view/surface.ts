import { Color, DataTexture, DoubleSide, GLSL3, LinearFilter, RGBAFormat, ShaderMaterial, Vector2 } from 'three';
import { type MapName, colourTable } from './colours';

/** What a surface shows. */
export type SurfaceLook = 'shaded' | 'normals' | 'values' | 'colours';
const LOOKS: SurfaceLook[] = ['shaded', 'normals', 'values', 'colours'];

/** A light that goes with the eye, so that every side can be judged. Values keep their colour where the surface faces the eye. */
export function surfaceMaterial(): ShaderMaterial {
  return new ShaderMaterial({
    glslVersion: GLSL3,
    side: DoubleSide,
    // Behind the lines of the wireframe.
    polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
    uniforms: {
      look: { value: 0 },
      flatShading: { value: false },
      clay: { value: new Color() },
      range: { value: new Vector2(0, 1) },
      map: { value: null },
    },
    vertexShader: `
      in float value;
      in vec3 vertexColour;
      out vec3 seen, facing, own, colour;
      out float amount;
      void main() {
        vec4 place = modelViewMatrix * vec4(position, 1.0);
        seen = place.xyz;
        facing = normalMatrix * normal;
        own = normal;
        colour = vertexColour;
        amount = value;
        gl_Position = projectionMatrix * place;
      }`,
    fragmentShader: `
      in vec3 seen, facing, own, colour;
      in float amount;
      out vec4 result;
      uniform int look;
      uniform bool flatShading;
      uniform vec3 clay;
      uniform vec2 range;
      uniform sampler2D map;
      void main() {
        vec3 flatNormal = normalize(cross(dFdx(seen), dFdy(seen)));
        vec3 n = flatShading || dot(facing, facing) < 1e-6 ? flatNormal : normalize(facing);
        vec3 eye = normalize(-seen);
        bool behind = !gl_FrontFacing;
        if (behind && dot(n, eye) < 0.0) n = -n;
        float towards = max(dot(n, eye), 0.0);
        if (look == 2) {
          float at = clamp((amount - range.x) / max(range.y - range.x, 1e-30), 0.0, 1.0);
          result = vec4(texture(map, vec2(at * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb * mix(0.62, 1.0, smoothstep(0.0, 0.9, towards)), 1.0);
          return;
        }
        if (look == 1) {
          result = vec4(normalize(own) * 0.5 + 0.5, 1.0);
          return;
        }
        vec3 lamp = normalize(vec3(-0.38, 0.55, 0.74));
        float key = max(dot(n, lamp), 0.0);
        float fill = 0.5 + 0.5 * dot(n, normalize(vec3(0.8, 0.15, 0.3)));
        float shine = pow(max(dot(reflect(-lamp, n), eye), 0.0), 28.0);
        vec3 base = look == 3 ? colour : behind ? clay * vec3(0.7, 0.58, 0.58) : clay;
        vec3 light = base * (vec3(0.26, 0.27, 0.3) + key * vec3(0.6, 0.585, 0.56) + fill * vec3(0.28, 0.29, 0.31)) + 0.07 * shine;
        result = vec4(light, 1.0);
      }`,
  });
}

export function setLook(material: ShaderMaterial, look: SurfaceLook): void {
  material.uniforms.look.value = LOOKS.indexOf(look);
}

const textures = new Map<MapName, DataTexture>();

export function setColourMap(material: ShaderMaterial, map: MapName, low: number, high: number): void {
  let texture = textures.get(map);
  if (!texture) {
    texture = new DataTexture(colourTable(map), 256, 1, RGBAFormat);
    texture.minFilter = texture.magFilter = LinearFilter;
    texture.needsUpdate = true;
    textures.set(map, texture);
  }
  material.uniforms.map.value = texture;
  (material.uniforms.range.value as Vector2).set(low, high);
}
