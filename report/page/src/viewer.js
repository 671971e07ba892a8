import { html } from "htl";
import {
  BufferAttribute, BufferGeometry, Mesh, MeshBasicMaterial, PerspectiveCamera, Raycaster, SphereGeometry, Spherical, Triangle,
  Vector2, Vector3,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

import { whenSeen } from "./seen.js";
import { makeRenderer, materialOf, modeMaterial, Stage } from "./stage.js";
import { meanThickness } from "./surface.js";

const turnStep = Math.PI / 18;
let viewers = 0;

// Shows one object and says where it is struck: struck({position, corners, weights}), the vertices of the
// point's face with the weights that interpolate between them; turned() after the camera has moved.
export class Viewer {
  constructor({ name, struck, turned }) {
    const keys = `viewer-keys-${++viewers}`;
    this.element = html`<div class="viewer" role="group" tabindex="0" aria-label=${`${name} in three dimensions`} aria-describedby=${keys}>
      <p class="keys" id=${keys}>Arrow keys turn it, plus and minus zoom, Enter strikes it at the cross.</p></div>`;
    this.struck = struck;
    this.turned = turned;
    this.stage = new Stage();
    this.scene = this.stage.scene;
    this.camera = new PerspectiveCamera(35, 1, 0.01, 100);
    this.camera.up.set(0, 0, 1);
    // Glass shows what lies behind it but for what is transparent: the dot is seen once.
    this.dot = new Mesh(new SphereGeometry(1, 16, 12), new MeshBasicMaterial({ color: 0xd55e00, toneMapped: false, transparent: true }));
    this.scene.add(this.dot);
    this.center = new Vector3();
    this.start();
  }

  // Without WebGL the object is not seen, and can be struck all the same.
  start() {
    try {
      this.renderer = makeRenderer();
    } catch {
      this.element.append(html`<p class="note">This browser shows no WebGL, so that the object is not drawn: strike it anywhere by the button.</p>`);
      return;
    }
    const canvas = this.renderer.domElement;
    canvas.setAttribute("role", "img");
    this.element.append(canvas);
    this.orbit(canvas);
    this.listen(canvas);
    this.stage.whenRepainted(() => this.render());
    new ResizeObserver(([entry]) => this.resize(entry.contentRect.width)).observe(this.element);
    whenSeen(this.element, () => {
      this.stage.furnish(this.renderer);
      this.isLit = true;
      this.render();
    });
  }

  orbit(canvas) {
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enablePan = false;
    // A finger that moves up or down scrolls the page, and so does the wheel until the object is held.
    canvas.style.touchAction = "pan-y";
    this.controls.enableZoom = false;
    canvas.addEventListener("pointerdown", () => (this.controls.enableZoom = true));
    canvas.addEventListener("pointerleave", () => (this.controls.enableZoom = false));
    this.controls.addEventListener("change", () => {
      this.render();
      if (!this.isFollowing) this.turned();
    });
  }

  listen(canvas) {
    let begun = null;
    canvas.addEventListener("pointerdown", (event) => (begun = [event.clientX, event.clientY]));
    canvas.addEventListener("pointerup", (event) => {
      if (!begun || Math.hypot(event.clientX - begun[0], event.clientY - begun[1]) > 5) return; // a drag
      const box = canvas.getBoundingClientRect();
      this.strikeAt(new Vector2((2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height));
    });
    const keys = {
      ArrowLeft: () => this.turn(-turnStep, 0),
      ArrowRight: () => this.turn(turnStep, 0),
      ArrowUp: () => this.turn(0, -turnStep),
      ArrowDown: () => this.turn(0, turnStep),
      "+": () => this.turn(0, 0, 0.9),
      "-": () => this.turn(0, 0, 1 / 0.9),
      Enter: () => this.strikeAt(new Vector2(0, 0)),
    };
    this.element.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey || !keys[event.key]) return;
      event.preventDefault();
      keys[event.key]();
    });
  }

  // By angles [rad] about the vertical and from it, and the distance by a factor.
  turn(around, down, factor = 1) {
    const place = new Spherical().setFromVector3(this.eye().applyAxisAngle(new Vector3(1, 0, 0), -Math.PI / 2));
    place.set(place.radius * factor, place.phi + down, place.theta + around).makeSafe();
    this.look(new Vector3().setFromSpherical(place).applyAxisAngle(new Vector3(1, 0, 0), Math.PI / 2));
    this.turned();
  }

  // From the object's centre to the camera, in its radii.
  eye() {
    return this.camera.position.clone().sub(this.center).divideScalar(this.radius);
  }

  // Looks from there; turned() is not called.
  look(eye) {
    this.isFollowing = true;
    this.camera.position.copy(this.center).addScaledVector(eye, this.radius);
    this.camera.lookAt(this.center);
    this.controls?.target.copy(this.center);
    this.controls?.update();
    this.isFollowing = false;
    this.render();
  }

  resize(width) {
    const height = Math.min(width, 420);
    if (width <= 0) return;
    this.renderer.setPixelRatio(devicePixelRatio);
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.render();
  }

  show(object) {
    this.object = object;
    this.mode = null;
    if (this.mesh) {
      this.scene.remove(this.mesh);
      this.mesh.geometry.dispose();
      for (const material of [...this.looks, this.modeLook]) material.dispose();
    }
    const geometry = geometryOf(object);
    const { center, radius } = geometry.boundingSphere;
    this.center.copy(center);
    this.radius = radius;
    this.looks = object.looks.map((look) => materialOf(look, object.colours !== undefined, meanThickness(object)));
    this.modeLook = modeMaterial();
    this.mesh = new Mesh(geometry, this.looks);
    this.mesh.castShadow = this.mesh.receiveShadow = true;
    this.mesh.frustumCulled = false; // it moves
    this.scene.add(this.mesh);
    geometry.boundingSphere.radius *= 1.5; // that a ray looks in, wherever a mode moves the surface
    this.stage.fit(center, radius, lowestOf(object));
    this.dot.visible = false;
    this.dot.scale.setScalar(0.025 * radius);
    this.camera.near = radius / 50;
    this.camera.far = 50 * radius;
    this.camera.updateProjectionMatrix();
    this.look(new Vector3(-1.6, -2.4, 1.8).multiplyScalar(1.15));
  }

  // What a reader of the screen is told that the picture shows.
  describe(text) {
    this.renderer?.domElement.setAttribute("aria-label", text);
  }

  // Colours the surface by a mode's displacement along the normal: blue inwards, red outwards; null: its own looks.
  color(mode) {
    const { geometry } = this.mesh;
    this.mode = mode;
    this.mesh.material = mode === null ? this.looks : this.modeLook;
    if (mode === null) setColors(geometry, ownColors(this.object));
    else setColors(geometry, modeColors(this.object, mode));
    this.deflect(0);
  }

  // Moves the surface as the coloured mode does. share: of the object's radius, at the mode's largest displacement.
  deflect(share) {
    const influences = this.mesh.morphTargetInfluences ?? [];
    influences.fill(0);
    this.deflection = this.mode < influences.length && this.mode !== null ? share * this.radius : 0;
    if (this.deflection !== 0) influences[this.mode] = this.deflection;
    if (this.hit) this.placeDot();
    this.render();
  }

  mark(hit) {
    this.hit = hit;
    this.dot.visible = hit !== null;
    if (hit) this.placeDot();
    this.render();
  }

  // On the surface, wherever that has moved.
  placeDot() {
    this.dot.position.set(...this.hit.position);
    if (!this.deflection) return;
    const moved = this.mesh.geometry.morphAttributes.position[this.mode];
    const part = new Vector3();
    this.hit.corners.forEach((vertex, i) => this.dot.position.addScaledVector(part.fromBufferAttribute(moved, vertex), this.hit.weights[i] * this.deflection));
  }

  // With the screen's next picture, however often it is called before.
  render() {
    if (!this.isLit || this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => {
      this.isDue = false;
      this.renderer.render(this.scene, this.camera);
    });
  }

  // Where a vertex is drawn [m].
  drawn(vertex) {
    return this.mesh.getVertexPosition(vertex, new Vector3()).toArray();
  }

  // place: across and up the picture, -1 to 1.
  strikeAt(place) {
    const ray = new Raycaster();
    ray.setFromCamera(place, this.camera);
    const [hit] = ray.intersectObject(this.mesh);
    if (hit) this.struck(this.on(hit.faceIndex, hit.barycoord));
  }

  corner(triangle, k) {
    const vertex = this.object.triangles[3 * triangle + k];
    return new Vector3().fromArray(this.object.vertices, 3 * vertex);
  }

  triangle(index) {
    return new Triangle(this.corner(index, 0), this.corner(index, 1), this.corner(index, 2));
  }

  // weights: of the triangle's corners.
  on(index, weights) {
    const { a, b, c } = this.triangle(index);
    const position = new Vector3().addScaledVector(a, weights.x).addScaledVector(b, weights.y).addScaledVector(c, weights.z);
    return { position: position.toArray(), ...this.object.onFace(index, weights.toArray()) };
  }

  // The point of the surface that is nearest to a position.
  nearest(position) {
    const from = new Vector3(...position);
    let best = { distance: Infinity };
    for (let index = 0; index < this.object.triangles.length / 3; ++index) {
      const triangle = this.triangle(index);
      const point = triangle.closestPointToPoint(from, new Vector3());
      const distance = point.distanceToSquared(from);
      if (distance < best.distance) best = { distance, index, weights: triangle.getBarycoord(point, new Vector3()) };
    }
    return this.on(best.index, best.weights);
  }

  // The middle of a triangle, drawn by area.
  anywhere() {
    const count = this.object.triangles.length / 3;
    const sums = new Float64Array(count);
    let sum = 0;
    for (let index = 0; index < count; ++index) sums[index] = sum += this.triangle(index).getArea();
    const place = Math.random() * sum;
    return this.on(sums.findIndex((value) => value >= place), new Vector3(1, 1, 1).divideScalar(3));
  }
}

// Each part of the surface is a group, each mode that moves a target of it.
function geometryOf(object) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(object.vertices, 3));
  geometry.setAttribute("normal", new BufferAttribute(object.normals, 3, true));
  geometry.setIndex(new BufferAttribute(object.triangles, 1));
  setColors(geometry, ownColors(object));
  let first = 0;
  object.looks.forEach(({ faces }, part) => {
    const count = 3 * faces * object.order ** 2;
    geometry.addGroup(first, count, part);
    first += count;
  });
  geometry.computeBoundingSphere(); // at rest
  geometry.morphTargetsRelative = true;
  geometry.morphAttributes.position = object.moving.map((shape) => new BufferAttribute(shape, 3, true));
  return geometry;
}

function lowestOf({ vertices }) {
  let lowest = Infinity;
  for (let k = 2; k < vertices.length; k += 3) lowest = Math.min(lowest, vertices[k]);
  return lowest;
}

function setColors(geometry, colors) {
  if (colors) geometry.setAttribute("color", new BufferAttribute(colors, 3));
  else geometry.deleteAttribute("color");
}

// Bytes are roots of linear reflectances.
function ownColors({ colours }) {
  return colours && Float32Array.from(colours, (byte) => (byte / 255) ** 2);
}

function modeColors(object, mode) {
  const count = object.vertices.length / 3;
  const colors = new Float32Array(3 * count);
  for (let vertex = 0; vertex < count; ++vertex) {
    const share = object.gain(mode, vertex) / object.gain_scales[mode];
    const pale = 1 - Math.abs(share);
    colors.set(share > 0 ? [0.9, 0.9 * pale, 0.9 * pale] : [0.9 * pale, 0.9 * pale, 0.9], 3 * vertex);
  }
  return colors;
}
