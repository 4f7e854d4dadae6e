// A picture with depth as an object of a three.js scene: WebGL's own depth test decides pixel by
// pixel whether a polygon or the field is in front.

import * as THREE from "three";

const VERTEX = `
  out vec2 at;
  void main() {
    at = 0.5 * position.xy + 0.5;
    gl_Position = vec4(position.xy, 0.0, 1.0);
  }
`;

const FRAGMENT = `
  precision highp float;
  uniform sampler2D colors, depths;
  uniform vec2 size, focal, center;
  uniform float near, far;
  in vec2 at;
  out vec4 color;
  void main() {
    // Pictures begin at the top.
    vec2 place = vec2(at.x, 1.0 - at.y);
    color = texture(colors, place);
    if (color.a == 0.0) discard;
    // Nearest pixels: depths of two surfaces have no mean.
    vec2 pixel = floor(place * size) + 0.5;
    float distance = texelFetch(depths, ivec2(pixel), 0).r;
    // Along the ray, to along the camera's axis, to the value of the depth buffer.
    float z = distance / length(vec3((pixel - center) / focal, 1.0));
    float depth = (far + near - 2.0 * far * near / z) / (far - near);
    gl_FragDepth = clamp(0.5 + 0.5 * depth, 0.0, 1.0);
  }
`;

export class Field {
  #uniforms = {
    colors: { value: null },
    depths: { value: null },
    size: { value: new THREE.Vector2() },
    focal: { value: new THREE.Vector2() },
    center: { value: new THREE.Vector2() },
    near: { value: 1 },
    far: { value: 2 },
  };
  /** To be added to a scene; drawn over all of the screen, after what is opaque. */
  mesh;

  constructor() {
    const material = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: this.#uniforms,
      transparent: true,
      // Colours are multiplied by alpha, and blended in sRGB, as the field was trained.
      blending: THREE.CustomBlending,
      blendSrc: THREE.OneFactor,
      blendDst: THREE.OneMinusSrcAlphaFactor,
    });
    this.mesh = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material);
    this.mesh.frustumCulled = false;
    this.mesh.visible = false;
    this.mesh.onBeforeRender = (renderer, scene, camera) => {
      this.#uniforms.near.value = camera.near;
      this.#uniforms.far.value = camera.far;
      material.uniformsNeedUpdate = true;
    };
  }

  /** Shows a layer of pocketnerf's, as `camera` has seen it; null: the last one stays. */
  show(layer, camera) {
    if (!layer) return;
    const { width, height, pixels, depth } = layer;
    const bytes = new Uint8Array(pixels.buffer, pixels.byteOffset, pixels.length);
    this.#replace("colors", new THREE.DataTexture(bytes, width, height, THREE.RGBAFormat));
    this.#uniforms.colors.value.magFilter = THREE.LinearFilter;
    const type = THREE.FloatType;
    this.#replace("depths", new THREE.DataTexture(depth, width, height, THREE.RedFormat, type));
    this.#uniforms.size.value.set(width, height);
    this.#uniforms.focal.value.set(...camera.focal);
    this.#uniforms.center.value.set(...camera.center);
    this.mesh.visible = true;
  }

  #replace(name, texture) {
    this.#uniforms[name].value?.dispose();
    texture.needsUpdate = true;
    this.#uniforms[name].value = texture;
  }
}
