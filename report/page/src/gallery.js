import { html } from "htl";

import { float32s, float64s, int16s, int8s, uint8s } from "./arrays.js";
import { Desk } from "./desk.js";
import { modesTable } from "./matched.js";
import { surfaceOf } from "./surface.js";

export function gallerySection({ gallery }) {
  if (gallery.objects.length === 0) return null;
  return {
    id: "gallery",
    title: "Objects to strike",
    content: () => content(gallery),
  };
}

let shown = null;

function content(gallery) {
  shown = new Gallery(gallery.objects.map(unpack), gallery.materials);
  const { desk } = shown;
  // For programs that drive the page: a strike as numbers, and what it sounds like; the last one heard; where a
  // vertex is drawn.
  window.carillon = { strike: (strike) => desk.strikeAt(strike), heard: () => desk.heard, drawn: (vertex) => desk.viewer.drawn(vertex) };
  return html`<p>Click an object to strike it there, against its surface; drag to turn it. Its modes are the dataset's, and what is heard is
      the velocity of the struck point, as <code>carillon strike</code> computes it without a listener, from the modes that are here. Other materials and
      sizes are exact rescalings of them; Poisson's ratio stays that of the object.${leftOut(gallery)}</p>${shown.element}`;
}

function leftOut({ total, left_out }) {
  const why = Object.entries(left_out).filter(([, number]) => number > 0);
  if (why.length === 0) return "";
  return ` Of ${total} objects these are not here: ${why.map(([reason, number]) => `${number} ${reason}`).join(", ")}.`;
}

// Where an object of a dataset stands in the gallery, and a mode of its modes file: {index, mode}, of which mode
// is null where it is not here; null where the object is not.
export function placeInGallery({ objects }, { dataset, object, set, in_set }) {
  const index = objects.findIndex((one) => one.dataset === dataset && one.object === object);
  if (index < 0) return null;
  const mode = objects[index].set === set ? in_set - objects[index].modes_below : -1;
  return { index, mode: mode >= 0 && mode < objects[index].gain_scales.length ? mode : null };
}

// A link to an object in the gallery, and a mode of it.
export function galleryLink(gallery, where, text) {
  const place = placeInGallery(gallery, where);
  if (!place) return text;
  return html`<a href="#gallery" onclick=${() => shown.show(place)}>${text}</a>`;
}

// An object's arrays. gain: displacement along the normal, of a mode at a vertex [kg^-1/2]; moving: displacements
// of the lowest modes, x y z for each vertex, of which 127 is the largest.
function unpack(object) {
  const scaled = int16s(object.gains);
  const shapes = int8s(object.shapes);
  const vertices = object.vertices_count;
  return {
    ...object,
    vertices: float32s(object.vertices),
    normals: int8s(object.normals),
    colours: object.colours && uint8s(object.colours),
    ...surfaceOf(object),
    eigenvalues: float64s(object.eigenvalues),
    errors: object.pitch_errors && float32s(object.pitch_errors),
    gain: (mode, vertex) => (scaled[mode * vertices + vertex] / 32767) * object.gain_scales[mode],
    moving: object.shape_scales.map((_, mode) => shapes.subarray(3 * vertices * mode, 3 * vertices * (mode + 1))),
    ownRate: object.damping && tabulated(object.damping),
  };
}

// Decay rate [1/s] of a mode whose eigenvalue is multiplied by a factor, from its table over the
// factor's logarithm: straight between the points on logarithmic scales, as power laws are.
function tabulated({ rates, widest_factor }) {
  const table = float32s(rates);
  return (mode, factor, modes) => {
    const points = table.length / modes;
    const place = Math.min(1, Math.max(0, (Math.log(factor) / Math.log(widest_factor) + 1) / 2)) * (points - 1);
    const low = Math.min(Math.floor(place), points - 2);
    const [a, b] = [table[mode * points + low], table[mode * points + low + 1]];
    const part = place - low;
    return a > 0 && b > 0 ? a * (b / a) ** part : a + part * (b - a);
  };
}

// One object, or two beside each other.
class Gallery {
  constructor(objects, materials) {
    this.objects = objects;
    this.materials = materials;
    this.desk = this.makeDesk("Object", () => this.other);
    this.desks = html`<div class="desks">${this.desk.element}</div>`;
    this.button = html`<button type="button" aria-expanded="false">Put a second object beside it</button>`;
    this.button.onclick = () => this.setBeside(!this.isBeside);
    this.linked = html`<input type="checkbox" checked>`;
    this.linked.onchange = () => this.follow(this.desk, this.other);
    this.by = html`<select><option value="pitch">nearest in pitch</option><option value="number">of equal number</option></select>`;
    this.by.onchange = () => this.compare();
    this.table = html`<div></div>`;
    this.beside = html`<div class="beside" hidden>
      <div class="controls"><label class="check">${this.linked} Turn both together</label><label>Match modes ${this.by}</label></div>
      ${this.table}
      <p class="note">Nearest in pitch: each is the other's nearest. Errors are estimates of each mode's own.</p></div>`;
    this.element = html`<div>${this.desks}<p class="buttons">${this.button}</p>${this.beside}</div>`;
  }

  makeDesk(name, other) {
    const desk = new Desk(this.objects, this.materials, { name, told: () => this.compare(), turned: () => this.follow(desk, other()) });
    return desk;
  }

  // The second object is made when it is first asked for.
  setBeside(isBeside) {
    this.isBeside = isBeside;
    if (isBeside && !this.other) {
      this.other = this.makeDesk("Second object", () => this.desk);
      this.other.choose(this.objects.length > 1 ? (this.desk.index + 1) % this.objects.length : 0);
      this.desks.append(this.other.element);
    }
    this.desks.classList.toggle("two", isBeside);
    this.other.element.hidden = !isBeside;
    if (!isBeside) this.other.swing.pause();
    this.beside.hidden = !isBeside;
    this.button.textContent = isBeside ? "Show one object alone" : "Put a second object beside it";
    this.button.setAttribute("aria-expanded", String(isBeside));
    this.follow(this.desk, this.other);
    this.compare();
  }

  follow(turned, other) {
    if (this.isBeside && this.linked.checked && other) other.viewer.look(turned.viewer.eye());
  }

  compare() {
    if (!this.isBeside || !this.other) return;
    const { desk, other } = this;
    // Of one object in two sizes or materials, mode by mode; until the reader chooses otherwise.
    const chosen = `${desk.index} ${other.index}`;
    if (this.chosen !== chosen) this.by.value = desk.index === other.index ? "number" : "pitch";
    this.chosen = chosen;
    const show = (pair) => [desk, other].forEach(({ swing }, side) => swing.choose(pair[side]));
    this.table.replaceChildren(modesTable(desk.allFacts(), other.allFacts(), this.by.value === "number", show));
  }

  show({ index, mode }) {
    this.desk.choose(index);
    this.desk.swing.choose(mode);
  }
}
