import { html } from "htl";
import {
  AmbientLight, BufferAttribute, BufferGeometry, Color, DirectionalLight, HemisphereLight, Mesh, MeshBasicMaterial,
  MeshStandardMaterial, PerspectiveCamera, Raycaster, Scene, SphereGeometry, Triangle, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

// Shows one object and says where it is clicked: struck({position, corners, weights}), the vertices of the
// point's face with the weights that interpolate between them.
export class Viewer {
  constructor(struck) {
    this.element = html`<div class="viewer" role="group" aria-label="The object in three dimensions; buttons below strike it without a pointer"></div>`;
    this.scene = new Scene();
    this.scene.add(new AmbientLight(0xffffff, 0.6), new HemisphereLight(0xffffff, 0x667788, 1.6));
    const light = new DirectionalLight(0xffffff, 2.2);
    light.position.set(-2, -3, 4);
    this.scene.add(light);
    this.camera = new PerspectiveCamera(35, 1, 0.01, 100);
    this.camera.up.set(0, 0, 1);
    this.dot = new Mesh(new SphereGeometry(1, 16, 12), new MeshBasicMaterial({ color: 0xd55e00 }));
    this.scene.add(this.dot);
    this.start(struck);
  }

  // Without WebGL the object is not seen, and can be struck all the same.
  start(struck) {
    try {
      this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    } catch {
      this.element.append(html`<p class="note">This browser shows no WebGL: strike anywhere by the button.</p>`);
      return;
    }
    const canvas = this.renderer.domElement;
    this.element.append(canvas);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enablePan = false;
    // A finger that moves up or down scrolls the page, and so does the wheel until the object is held.
    canvas.style.touchAction = "pan-y";
    this.controls.enableZoom = false;
    canvas.addEventListener("pointerdown", () => (this.controls.enableZoom = true));
    canvas.addEventListener("pointerleave", () => (this.controls.enableZoom = false));
    this.controls.addEventListener("change", () => this.render());
    let begun = null;
    canvas.addEventListener("pointerdown", (event) => (begun = [event.clientX, event.clientY]));
    canvas.addEventListener("pointerup", (event) => {
      if (!begun || Math.hypot(event.clientX - begun[0], event.clientY - begun[1]) > 5) return; // a drag
      const hit = this.under(event);
      if (hit) struck(hit);
    });
    new ResizeObserver(([entry]) => this.resize(entry.contentRect.width)).observe(this.element);
  }

  resize(width) {
    const height = Math.min(width, 420);
    this.renderer.setPixelRatio(devicePixelRatio);
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.render();
  }

  show(object) {
    this.object = object;
    if (this.mesh) {
      this.scene.remove(this.mesh);
      this.mesh.geometry.dispose();
      this.mesh.material.dispose();
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(object.vertices, 3));
    geometry.setAttribute("normal", new BufferAttribute(object.normals, 3, true));
    geometry.setIndex(new BufferAttribute(object.triangles, 1));
    geometry.computeBoundingSphere();
    const { color, roughness, metallic } = object.appearance;
    this.own = new Color().setRGB(...color);
    this.mesh = new Mesh(geometry, new MeshStandardMaterial({ color: this.own, roughness: Math.max(roughness, 0.45), metalness: 0.4 * metallic }));
    this.scene.add(this.mesh);
    const { center, radius } = geometry.boundingSphere;
    this.radius = radius;
    this.dot.visible = false;
    this.dot.scale.setScalar(0.025 * radius);
    this.camera.near = radius / 50;
    this.camera.far = 50 * radius;
    this.camera.position.copy(center).add(new Vector3(-1.6, -2.4, 1.8).multiplyScalar(1.15 * radius));
    this.camera.updateProjectionMatrix();
    if (this.controls) {
      this.controls.target.copy(center);
      this.controls.update();
    }
    this.camera.lookAt(center);
    this.render();
  }

  // Colours the surface by a mode's displacement along the normal: blue inwards, red outwards.
  color(mode) {
    const { geometry, material } = this.mesh;
    material.vertexColors = mode !== null;
    material.color = mode === null ? this.own : new Color(1, 1, 1);
    material.needsUpdate = true;
    if (mode !== null) {
      const count = this.object.vertices.length / 3;
      const colors = new Float32Array(3 * count);
      for (let vertex = 0; vertex < count; ++vertex) {
        const share = this.object.gain(mode, vertex) / this.object.gain_scales[mode];
        const pale = 1 - Math.abs(share);
        colors.set(share > 0 ? [0.9, 0.9 * pale, 0.9 * pale] : [0.9 * pale, 0.9 * pale, 0.9], 3 * vertex);
      }
      geometry.setAttribute("color", new BufferAttribute(colors, 3));
    }
    this.render();
  }

  mark(position) {
    this.dot.position.set(...position);
    this.dot.visible = true;
    this.render();
  }

  render() {
    this.renderer?.render(this.scene, this.camera);
  }

  under(event) {
    const box = this.renderer.domElement.getBoundingClientRect();
    const place = new Vector2((2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height);
    const ray = new Raycaster();
    ray.setFromCamera(place, this.camera);
    const [hit] = ray.intersectObject(this.mesh);
    return hit ? this.on(hit.faceIndex, hit.point) : null;
  }

  corner(triangle, k) {
    const vertex = this.object.triangles[3 * triangle + k];
    return new Vector3().fromArray(this.object.vertices, 3 * vertex);
  }

  triangle(index) {
    return new Triangle(this.corner(index, 0), this.corner(index, 1), this.corner(index, 2));
  }

  on(index, point) {
    const weights = new Vector3();
    this.triangle(index).getBarycoord(point, weights);
    return { position: point.toArray(), ...this.object.onFace(index, weights.toArray()) };
  }

  // The point of the surface that is nearest to a position.
  nearest(position) {
    const from = new Vector3(...position);
    let best = { distance: Infinity };
    for (let index = 0; index < this.object.triangles.length / 3; ++index) {
      const point = this.triangle(index).closestPointToPoint(from, new Vector3());
      const distance = point.distanceToSquared(from);
      if (distance < best.distance) best = { distance, index, point };
    }
    return this.on(best.index, best.point);
  }

  // The middle of a triangle, drawn by area.
  anywhere() {
    const count = this.object.triangles.length / 3;
    const sums = new Float64Array(count);
    let sum = 0;
    for (let index = 0; index < count; ++index) sums[index] = sum += this.triangle(index).getArea();
    const place = Math.random() * sum;
    const index = sums.findIndex((value) => value >= place);
    return this.on(index, this.triangle(index).getMidpoint(new Vector3()));
  }
}
