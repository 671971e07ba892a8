import * as Plot from "@observablehq/plot";
import { html } from "htl";

import { base, colors } from "./figure.js";
import { hertz, number, seconds } from "./format.js";
import { amplitudeAfter, changed, levels, ring } from "./modal.js";
import { slider } from "./slider.js";
import { Swing } from "./swing.js";
import { Viewer } from "./viewer.js";

const defaults = { stiffness: 1, density: 1, size: 1, damping: 1, duration: 2e-4, impulse: 0.02 };
const fadeSeconds = 0.03;

// One object to strike, with what may be changed of it. name: of its place; told(): its modes are others now, or it is another object;
// turned(): it is seen from elsewhere.
export class Desk {
  constructor(objects, materials, { name, told, turned }) {
    this.objects = objects;
    this.materials = materials;
    this.told = told;
    this.viewer = new Viewer({ name, struck: (hit) => this.strike(hit), turned });
    this.swing = new Swing(this.viewer, { facts: (mode) => this.facts(mode), chosen: () => this.describe() });
    this.message = html`<p class="note" aria-live="polite">Not struck yet.</p>`;
    this.chart = html`<div class="chart"></div>`;
    this.limit = html`<p class="note"></p>`;
    this.looksNote = html`<p class="note"></p>`;
    this.controls = html`<form class="controls" aria-label=${`${name}: material, size and strike`} onsubmit=${(event) => event.preventDefault()}></form>`;
    this.select = html`<select aria-label=${name}>${this.objects.map((object, i) => html`<option value=${i}>${object.name}</option>`)}</select>`;
    this.select.onchange = () => this.choose(Number(this.select.value));
    this.element = html`<div class="desk">
      <div><p>${this.select}</p>${this.viewer.element}${this.looksNote}<p class="buttons">
        <button type="button" onclick=${() => this.strike(this.hit ?? this.viewer.anywhere())}>Strike again</button>
        <button type="button" onclick=${() => this.strike(this.viewer.anywhere())}>Strike anywhere</button>
        <button type="button" onclick=${() => this.choose(this.index)}>As it was</button></p>
        ${this.message}${this.swing.element}</div>
      <div>${this.controls}${this.chart}${this.limit}</div>
    </div>`;
    new ResizeObserver(() => this.hit && this.draw()).observe(this.chart);
    this.choose(0);
  }

  choose(index) {
    this.index = index;
    this.select.value = index;
    const [alpha1, alpha2] = this.objects[index].rayleigh ?? [];
    this.state = { ...defaults, alpha1, alpha2 };
    this.object = { ...this.objects[index], scale: () => this.state.size };
    this.hit = null;
    this.volume = null;
    this.viewer.show(this.object);
    this.swing.show(this.object);
    this.fillControls();
    this.chart.replaceChildren(html`<p class="note">Its modes are drawn here once it is struck.</p>`);
    this.message.textContent = `${this.object.name}: ${this.object.eigenvalues.length} modes from ${hertz(Math.sqrt(this.object.eigenvalues[0]) / 2 / Math.PI)}. Not struck yet.`;
    this.looksNote.textContent = this.object.regions > 1 && this.object.looks.slice(1).every(({ faces }) => faces === 0)
      ? "Of several materials, and shown in the look of the first: this dataset draws nothing, so that it does not say which face is of which." : "";
    this.tellLimit();
    this.describe();
    this.told();
  }

  describe() {
    const { name, looks } = this.object;
    const mode = this.swing.mode === null ? "" : `, coloured by mode ${this.swing.mode + 1} at ${hertz(this.facts(this.swing.mode).hertz)}`;
    this.viewer.describe(`${name}, ${number(2000 * this.viewer.radius * this.state.size, 3)} mm across${looks.length > 1 ? `, of ${looks.length} materials` : ""}${mode}`);
  }

  // What is known of a mode, with the settings as they are.
  facts(mode, modes = this.modes()) {
    const largest = this.hit && amplitudeAfter({ lambda: modes.lambda[mode], decay: modes.decay[mode] }, modes.shape * this.gainAt(this.hit, mode), this.state);
    const shape = this.object.shape_scales[mode];
    return {
      hertz: Math.sqrt(modes.lambda[mode]) / 2 / Math.PI,
      cents: this.object.errors ? this.object.errors[mode] : null,
      t60: Math.log(1000) / modes.decay[mode],
      largest: this.hit && shape ? largest * shape * modes.shape : null,
    };
  }

  allFacts() {
    const modes = this.modes();
    return { name: this.object.name, modes: modes.lambda.map((_, mode) => this.facts(mode, modes)) };
  }

  // Factor of all eigenvalues, by the settings.
  factor() {
    return this.state.stiffness / (this.state.density * this.state.size ** 2);
  }

  // Up to where what is heard has every mode, by the settings [Hz].
  completeTo() {
    return this.object.complete_to_hz * Math.sqrt(this.factor());
  }

  tellLimit() {
    const { modes_left_out: left, damping } = this.object;
    this.limit.textContent = `No mode is missing up to ${hertz(this.completeTo())}${left > 0 ? `; ${left} higher ones of the dataset are left out for the size of this page` : ""}.${
      this.state.alpha1 === undefined ? ` Damping: ${damping.law}.` : ""}`;
  }

  fillControls() {
    const put = (key, label, low, high, format) =>
      slider({ label, low, high, value: this.state[key], format, changed: (value) => this.set({ [key]: value }) });
    const isRayleigh = this.state.alpha1 !== undefined;
    this.controls.replaceChildren(
      ...[
        this.object.regions === 1 ? this.presets() : "",
        put("stiffness", "Stiffness", 0.05, 20, (v) => `× ${number(v, 3)}`),
        put("density", "Density", 0.1, 10, (v) => `× ${number(v, 3)}`),
        put("size", "Size", 0.25, 4, (v) => `× ${number(v, 3)}`),
        ...(isRayleigh
          ? [
              put("alpha1", "Damping α₁", 0.1, 1000, (v) => `${number(v, 3)} 1/s`),
              put("alpha2", "Damping α₂", 1e-10, 1e-4, (v) => `${number(v, 2)} s`),
            ]
          : [put("damping", "Damping", 0.05, 20, (v) => `× ${number(v, 3)}`)]),
        put("duration", "Contact time", 2e-5, 1e-2, seconds),
        put("impulse", "Impulse", 1e-3, 1, (v) => `${number(1000 * v, 3)} mN s`),
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

  // The settings that make the object one of another material, whose damping is Rayleigh's; of
  // null: its own.
  inMaterial(material) {
    const own = this.object;
    const [alpha1, alpha2] = material?.alphas ?? own.rayleigh ?? [];
    return {
      stiffness: material ? material.youngs_modulus / own.youngs_modulus : 1,
      density: material ? material.density / own.density : 1,
      damping: 1,
      alpha1,
      alpha2,
    };
  }

  // A change is heard at the point struck last.
  set(values) {
    Object.assign(this.state, values);
    this.tellLimit();
    if (this.hit) this.strike(this.hit);
    this.swing.list();
    this.swing.tell();
    this.describe();
    this.told();
  }

  modes() {
    const { alpha1, alpha2, damping } = this.state;
    const { ownRate, eigenvalues } = this.object;
    const factor = this.factor();
    return changed(this.object, this.state, (lambda, mode) =>
      alpha1 === undefined ? damping * ownRate(mode, factor, eigenvalues.length) : (alpha1 + alpha2 * lambda) / 2,
    );
  }

  gainAt({ corners, weights }, mode) {
    return corners.reduce((sum, vertex, i) => sum + weights[i] * this.object.gain(mode, vertex), 0);
  }

  gainsAt(hit, shape) {
    return Array.from(this.object.eigenvalues, (_, mode) => shape * this.gainAt(hit, mode));
  }

  strike(hit) {
    this.hit = hit;
    this.viewer.mark(hit);
    const audio = (this.audio ??= new AudioContext());
    audio.resume();
    const modes = this.modes();
    const slowest = Math.min(...modes.decay.filter((decay) => decay > 0));
    const length = Math.min(4, Math.max(0.3, Math.log(1e4) / slowest || 4));
    const sound = ring(modes, this.gainsAt(hit, modes.shape), this.state, audio.sampleRate, Math.ceil(length * audio.sampleRate));
    const peak = sound.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
    // One volume for an object, so that harder strikes are louder; never beyond full scale.
    this.volume ??= 0.4 / (peak || 1);
    const volume = Math.min(this.volume, 0.95 / (peak || 1));
    const fade = Math.min(sound.length, Math.round(0.01 * audio.sampleRate));
    const buffer = audio.createBuffer(1, sound.length, audio.sampleRate);
    const channel = buffer.getChannelData(0);
    for (let i = 0; i < sound.length; ++i) channel[i] = volume * sound[i] * Math.min(1, (sound.length - i) / fade);
    this.play(audio, buffer);
    this.heard = { object: this.index, ...this.state, position: hit.position, volume };
    this.message.textContent = `Struck at (${hit.position.map((x) => number(1000 * this.state.size * x, 3)).join(", ")}) mm: peak ${number(peak, 3)} m/s${volume < this.volume ? ", turned down to full scale" : ""}.`;
    this.draw();
    this.swing.tell();
  }

  // What rang before fades: together they would go beyond full scale.
  play(audio, buffer) {
    if (this.rings) {
      const { source, gain } = this.rings;
      gain.gain.setTargetAtTime(0, audio.currentTime, fadeSeconds / 5);
      source.stop(audio.currentTime + fadeSeconds);
    }
    const source = audio.createBufferSource();
    const gain = audio.createGain();
    source.buffer = buffer;
    source.connect(gain).connect(audio.destination);
    source.start();
    this.rings = { source, gain };
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
          x: { type: "log", label: "frequency [Hz]", labelOffset: 38, tickFormat: (hz) => (hz >= 1000 ? `${hz / 1000}k` : String(hz)), ticks: 5 },
          y: { label: "level after the strike [dB]", domain: [-80, 0], grid: true },
          marks: [
            Plot.ruleX([this.completeTo()].filter((limit) => rows.some((row) => row.hertz > 0.5 * limit)), { strokeDasharray: "4 3", strokeOpacity: 0.6 }),
            Plot.ruleX(rows, { x: "hertz", y1: -80, y2: "level", stroke: colors[0], strokeWidth: 2 }),
            Plot.tip(rows, Plot.pointerX({ x: "hertz", y: "level", title: (row) => `${hertz(row.hertz)}\n${number(row.level, 3)} dB\nT60 ${seconds(row.t60)}` })),
          ],
        }),
      ),
    );
  }

  // {object, position [m], impulse [N s], duration [s], sampleRate, seconds}: samples [m/s] of the
  // object struck at its nearest point, as it is or in another material ({youngs_modulus, density,
  // alphas: Rayleigh's two}) and size (factor; the position is that before it).
  strikeAt(strike) {
    this.choose(strike.object);
    if (strike.material && this.object.regions > 1) throw new Error(`${this.object.name} is of several materials`);
    if (strike.material) Object.assign(this.state, this.inMaterial(strike.material));
    this.state.size = strike.size ?? 1;
    const hit = this.viewer.nearest(strike.position);
    const modes = this.modes();
    return Array.from(ring(modes, this.gainsAt(hit, modes.shape), strike, strike.sampleRate, Math.round(strike.seconds * strike.sampleRate)));
  }
}
