import * as Plot from "@observablehq/plot";
import { html } from "htl";

import { float32s, float64s, int16s, int8s, uint32s } from "./arrays.js";
import { base, colors } from "./figure.js";
import { hertz, number, seconds } from "./format.js";
import { changed, levels, ring } from "./modal.js";
import { slider } from "./slider.js";
import { Viewer } from "./viewer.js";

export function gallerySection({ gallery }) {
  if (gallery.objects.length === 0) return null;
  const desk = new Desk(gallery.objects.map(unpack), gallery.materials);
  const left = gallery.bodies - gallery.objects.length;
  // For programs that drive the page: a blow as numbers, and what it sounds like.
  window.carillon = { strike: (blow) => desk.strikeAt(blow) };
  return {
    id: "gallery",
    title: "Objects to strike",
    content: html`<p>Click an object to strike it there, against its surface; drag to turn it. Its modes are the dataset's, and what is heard is
      the velocity of the struck point, as <code>carillon strike</code> computes it without a listener. Other materials and sizes are exact
      rescalings of the same modes; Poisson's ratio stays that of the object.${left > 0 ? ` ${left} of ${gallery.bodies} bodies are left out for the size of this page.` : ""}</p>${desk.element}`,
  };
}

// An object's arrays. gains: displacement along the normal, mode by mode over the vertices [kg^-1/2].
function unpack(object) {
  const scaled = int16s(object.gains);
  const vertices = object.vertices_count;
  return {
    ...object,
    vertices: float32s(object.vertices),
    normals: int8s(object.normals),
    triangles: uint32s(object.triangles),
    eigenvalues: float64s(object.eigenvalues),
    decayRates: float64s(object.decay_rates),
    gain: (mode, vertex) => (scaled[mode * vertices + vertex] / 32767) * object.gain_scales[mode],
  };
}

const defaults = { stiffness: 1, density: 1, size: 1, damping: 1, duration: 2e-4, impulse: 0.02 };

class Desk {
  constructor(objects, materials) {
    this.objects = objects;
    this.materials = materials;
    this.viewer = new Viewer((hit) => this.strike(hit));
    this.message = html`<p class="note" aria-live="polite">Not struck yet.</p>`;
    this.chart = html`<div class="chart"></div>`;
    this.controls = html`<form class="controls" onsubmit=${(event) => event.preventDefault()}></form>`;
    this.element = html`<div class="desk">
      <div>${this.chooser()}${this.viewer.element}<p class="buttons">
        <button type="button" onclick=${() => this.strike(this.hit ?? this.viewer.anywhere())}>Strike again</button>
        <button type="button" onclick=${() => this.strike(this.viewer.anywhere())}>Strike anywhere</button>
        <button type="button" onclick=${() => this.choose(this.index)}>As it was</button></p>
        ${this.message}</div>
      <div>${this.controls}${this.chart}</div>
    </div>`;
    new ResizeObserver(() => this.hit && this.draw()).observe(this.chart);
    this.choose(0);
  }

  chooser() {
    const select = html`<select aria-label="Object">${this.objects.map((object, i) => html`<option value=${i}>${object.name}</option>`)}</select>`;
    select.onchange = () => this.choose(Number(select.value));
    return html`<p>${select}</p>`;
  }

  choose(index) {
    this.index = index;
    this.object = this.objects[index];
    const { rayleigh } = this.object;
    this.state = { ...defaults, alpha1: rayleigh?.[0], alpha2: rayleigh?.[1] };
    this.hit = null;
    this.volume = null;
    this.viewer.show(this.object);
    this.fillControls();
    this.chart.replaceChildren(html`<p class="note">Its modes are drawn here once it is struck.</p>`);
    this.message.textContent = `${this.object.name}: ${this.object.eigenvalues.length} modes from ${hertz(Math.sqrt(this.object.eigenvalues[0]) / 2 / Math.PI)}${this.object.modes_left_out > 0 ? `; ${this.object.modes_left_out} higher ones are left out here` : ""}. Not struck yet.`;
  }

  fillControls() {
    const put = (key, label, low, high, format) =>
      slider({ label, low, high, value: this.state[key], format, changed: (value) => this.set({ [key]: value }) });
    const { rayleigh } = this.object;
    this.controls.replaceChildren(
      ...[
        rayleigh ? this.presets() : "",
        put("stiffness", "Stiffness", 0.05, 20, (v) => `× ${number(v, 3)}`),
        put("density", "Density", 0.1, 10, (v) => `× ${number(v, 3)}`),
        put("size", "Size", 0.25, 4, (v) => `× ${number(v, 3)}`),
        ...(rayleigh
          ? [
              put("alpha1", "Damping α₁", 0.1, 1000, (v) => `${number(v, 3)} 1/s`),
              put("alpha2", "Damping α₂", 1e-10, 1e-4, (v) => `${number(v, 2)} s`),
            ]
          : [put("damping", "Damping", 0.05, 20, (v) => `× ${number(v, 3)}`)]),
        put("duration", "Contact time", 2e-5, 1e-2, seconds),
        put("impulse", "Impulse", 1e-3, 1, (v) => `${number(1000 * v, 3)} mN s`),
        this.modeChooser(),
      ].filter(Boolean),
    );
  }

  presets() {
    const select = html`<select><option value="">${this.object.material} (its own)</option>${this.materials.map((material, i) => html`<option value=${i}>${material.name}</option>`)}</select>`;
    select.onchange = () => {
      this.set(this.inMaterial(select.value === "" ? null : this.materials[Number(select.value)]));
      const kept = select.value;
      this.fillControls();
      this.controls.querySelector("select").value = kept;
    };
    return html`<label>Material ${select}</label>`;
  }

  // The settings that make the object one of another material; of null: its own.
  inMaterial(material) {
    const own = this.object;
    return {
      stiffness: material ? material.youngs_modulus / own.youngs_modulus : 1,
      density: material ? material.density / own.density : 1,
      alpha1: (material?.alphas ?? own.rayleigh)[0],
      alpha2: (material?.alphas ?? own.rayleigh)[1],
    };
  }

  modeChooser() {
    const frequencies = Array.from(this.object.eigenvalues, (lambda) => Math.sqrt(lambda) / 2 / Math.PI);
    const select = html`<select><option value="">none</option>${frequencies.map((hz, i) => html`<option value=${i}>${i + 1}: ${hertz(hz)}</option>`)}</select>`;
    select.onchange = () => this.viewer.color(select.value === "" ? null : Number(select.value));
    return html`<label>Show mode ${select}</label>`;
  }

  // A change is heard at the point struck last.
  set(values) {
    Object.assign(this.state, values);
    if (this.hit) this.strike(this.hit);
  }

  modes() {
    const { alpha1, alpha2, damping } = this.state;
    const { rayleigh, eigenvalues, decayRates } = this.object;
    let mode = 0;
    return changed(this.object, this.state, (lambda) =>
      rayleigh ? (alpha1 + alpha2 * lambda) / 2 : damping * decayRates[mode++ % eigenvalues.length],
    );
  }

  gainsAt({ corners, weights }, shape) {
    return Array.from(this.object.eigenvalues, (_, mode) =>
      shape * corners.reduce((sum, vertex, i) => sum + weights[i] * this.object.gain(mode, vertex), 0),
    );
  }

  strike(hit) {
    this.hit = hit;
    this.viewer.mark(hit.position);
    const audio = (this.audio ??= new AudioContext());
    audio.resume();
    const modes = this.modes();
    const slowest = Math.min(...modes.decay.filter((decay) => decay > 0));
    const length = Math.min(4, Math.max(0.3, Math.log(1e4) / slowest || 4));
    const sound = ring(modes, this.gainsAt(hit, modes.shape), this.state, audio.sampleRate, Math.ceil(length * audio.sampleRate));
    const peak = sound.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
    // One volume for an object, so that harder blows are louder; never beyond full scale.
    this.volume ??= 0.4 / (peak || 1);
    const volume = Math.min(this.volume, 0.95 / (peak || 1));
    const fade = Math.min(sound.length, Math.round(0.01 * audio.sampleRate));
    const buffer = audio.createBuffer(1, sound.length, audio.sampleRate);
    const channel = buffer.getChannelData(0);
    for (let i = 0; i < sound.length; ++i) channel[i] = volume * sound[i] * Math.min(1, (sound.length - i) / fade);
    const source = audio.createBufferSource();
    source.buffer = buffer;
    source.connect(audio.destination);
    source.start();
    this.message.textContent = `Struck at (${hit.position.map((x) => number(1000 * x, 3)).join(", ")}) mm: peak ${number(peak, 3)} m/s${volume < this.volume ? ", turned down to full scale" : ""}.`;
    this.draw();
  }

  draw() {
    const modes = this.modes();
    const level = levels(modes, this.gainsAt(this.hit, modes.shape), this.state);
    const rows = modes.lambda
      .map((lambda, i) => ({ hertz: Math.sqrt(lambda) / 2 / Math.PI, level: level[i], t60: Math.log(1000) / modes.decay[i] }))
      .filter((row) => row.level > -80);
    const width = Math.floor(this.chart.clientWidth) || 320;
    this.chart.replaceChildren(
      Plot.plot(
        base(width, {
          height: 200,
          x: { type: "log", label: "frequency [Hz]", tickFormat: (hz) => (hz >= 1000 ? `${hz / 1000}k` : String(hz)), ticks: 5 },
          y: { label: "level after the blow [dB]", domain: [-80, 0], grid: true },
          marks: [
            Plot.ruleX(rows, { x: "hertz", y1: -80, y2: "level", stroke: colors[0], strokeWidth: 2 }),
            Plot.tip(rows, Plot.pointerX({ x: "hertz", y: "level", title: (row) => `${hertz(row.hertz)}\n${number(row.level, 3)} dB\nT60 ${seconds(row.t60)}` })),
          ],
        }),
      ),
    );
  }

  // {object, position [m], impulse [N s], duration [s], sampleRate, seconds}: samples [m/s] of the
  // object struck at its nearest point, as it is or in another material ({youngs_modulus, density,
  // alphas}) and size (factor; the position is that before it).
  strikeAt(blow) {
    this.choose(blow.object);
    if (blow.material) Object.assign(this.state, this.inMaterial(blow.material));
    this.state.size = blow.size ?? 1;
    const hit = this.viewer.nearest(blow.position);
    const modes = this.modes();
    return Array.from(ring(modes, this.gainsAt(hit, modes.shape), blow, blow.sampleRate, Math.round(blow.seconds * blow.sampleRate)));
  }
}
