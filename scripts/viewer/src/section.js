// A section plane with hatched cut faces. The stencil buffer counts how often the line of sight enters and leaves a body in
// front of the plane; where the count is not zero the plane cuts solid matter, and there the cap is drawn.
import {
  AlwaysStencilFunc, BackSide, Color, DecrementWrapStencilOp, DoubleSide, FrontSide, IncrementWrapStencilOp, Mesh,
  MeshBasicMaterial, NotEqualStencilFunc, Plane, PlaneGeometry, ReplaceStencilOp, Vector3,
} from "three";

export const AXES = { x: new Vector3(-1, 0, 0), y: new Vector3(0, 1, 0), z: new Vector3(0, 0, -1) };

export class Section {
  constructor(size) {
    this.plane = new Plane(AXES.x.clone(), 0);
    this.caps = [];
    this.on = false;
    this.size = size;
  }

  // Adds the counting meshes to the body's node, and its cap to the world.
  fit(node, geometry, world, order, role) {
    const counters = [
      [BackSide, IncrementWrapStencilOp],
      [FrontSide, DecrementWrapStencilOp],
    ].map(([side, step]) => {
      const material = new MeshBasicMaterial({
        side, depthWrite: false, depthTest: false, colorWrite: false, stencilWrite: true, stencilFunc: AlwaysStencilFunc,
        stencilFail: step, stencilZFail: step, stencilZPass: step, clippingPlanes: [this.plane],
      });
      const mesh = new Mesh(geometry, material);
      mesh.renderOrder = order;
      mesh.visible = false;
      mesh.raycast = () => {};
      node.add(mesh);
      return mesh;
    });
    const cap = new Mesh(new PlaneGeometry(this.size, this.size), capMaterial(role === "cam" ? 1 : -1));
    cap.renderOrder = order + 0.5;
    cap.visible = false;
    cap.raycast = () => {};
    cap.onAfterRender = (renderer) => renderer.clearStencil();
    world.add(cap);
    this.caps.push({ cap, counters });
  }

  set(axis, position) {
    this.on = axis !== "off";
    if (this.on) {
      this.plane.normal.copy(AXES[axis]);
      this.plane.constant = -position * (AXES[axis].x + AXES[axis].y + AXES[axis].z);
    }
    for (const { cap, counters } of this.caps) {
      for (const mesh of [cap, ...counters]) mesh.visible = this.on;
      this.plane.coplanarPoint(cap.position);
      cap.lookAt(cap.position.clone().sub(this.plane.normal));
    }
  }

  colour(paper, ink) {
    for (const { cap } of this.caps) {
      cap.material.color.set(paper);
      cap.material.userData.ink.value.copy(new Color(ink));
    }
  }

  shows(point) {
    return !this.on || this.plane.distanceToPoint(point) >= -1e-6;
  }
}

function capMaterial(slant) {
  const material = new MeshBasicMaterial({
    side: DoubleSide, stencilWrite: true, stencilRef: 0, stencilFunc: NotEqualStencilFunc, stencilFail: ReplaceStencilOp,
    stencilZFail: ReplaceStencilOp, stencilZPass: ReplaceStencilOp,
  });
  material.userData.ink = { value: new Color() };
  material.onBeforeCompile = (shader) => {
    shader.uniforms.ink = material.userData.ink;
    shader.fragmentShader = shader.fragmentShader
      .replace("void main() {", "uniform vec3 ink;\nvoid main() {")
      .replace(
        "#include <opaque_fragment>",
        `#include <opaque_fragment>\nfloat stripe = fract((gl_FragCoord.x + (${slant.toFixed(1)}) * gl_FragCoord.y) / 11.0);\n` +
          "gl_FragColor.rgb = mix(gl_FragColor.rgb, ink, 0.75 * smoothstep(0.80, 0.86, stripe) * (1.0 - smoothstep(0.94, 1.0, stripe)));",
      );
  };
  return material;
}
