import { html } from "htl";

import { isServed, listen, newest } from "./events.js";
import { bytes, count, number, percent, seconds } from "./format.js";
import { soundCard } from "./sound_card.js";

const newest_ms = 3000; // the newest samples are asked for not more often, of all builds together
const newest_count = 4;
const max_ranks = 64;

// Builds of the folders while they run; of a page that is a file there is nothing to say.
export function liveSection(report) {
  if (!isServed) return null;
  return { id: "live", title: "Builds under way", content: () => liveContent(report) };
}

function liveContent(report) {
  const state = html`<p class="note" role="status">Asking for builds …</p>`;
  const place = html`<div class="builds"></div>`;
  const cards = new Map();
  let lost = false;
  const say = (text) => {
    state.classList.toggle("bad", lost);
    if (state.textContent !== text) state.textContent = text;
  };
  const tell = () => {
    if (lost) say("The connection to the service is lost. Trying again …");
    else say(place.childElementCount > 0 ? "Connected: what is below changes as the builds do." : "No build is under way. One that begins appears here.");
  };
  listen({
    told: (news) => {
      const builds = news.builds ?? []; // null where none of the folders is there any more
      followBuilds(builds, cards, report);
      for (const card of cards.values()) {
        if (!builds.some((build) => build.folder === card.folder)) card.gone();
        if (card.is_news && !card.element.isConnected) place.append(card.element);
      }
      tell();
    },
    connected: (is) => {
      lost = !is;
      tell();
    },
    none: () => {
      lost = false;
      say("This page does not come from carillon serve: nothing is known of builds.");
    },
  });
  askForNewest(cards);
  return html`${state}${place}`;
}

// A build is shown once it runs, or has changed in any way while the page was open.
function followBuilds(builds, cards, report) {
  for (const build of builds) {
    let card = cards.get(build.folder);
    if (!card) {
      card = new BuildCard(build, isOnPage(build, report));
      cards.set(build.folder, card);
    }
    card.show(build);
  }
}

// Whether the page has all samples of a build; of a sweep those of its variants.
function isOnPage(build, report) {
  const own = report.datasets.filter(({ folder }) => folder === build.folder || folder.startsWith(`${build.folder}/`));
  return own.length > 0 && own.reduce((sum, dataset) => sum + dataset.samples, 0) === build.samples.done;
}

class BuildCard {
  constructor(build, isOnPage) {
    this.folder = build.folder;
    this.first = build.started;
    this.is_news = build.state !== "done" ? build.state === "running" : !isOnPage;
    this.state = html`<strong></strong>`;
    this.ended = html`<div role="status"></div>`;
    this.progress = html`<progress max="1" aria-label=${`${build.name}, done`}></progress>`;
    this.share = html`<span></span>`;
    this.facts = html`<dl class="tiles"></dl>`;
    this.ranks = html`<div></div>`;
    this.sounds = html`<div class="cards"></div>`;
    this.heard = html`<div hidden><h4>Newest samples</h4>${this.sounds}</div>`;
    this.element = html`<article class="card build">
      <h3>${build.name} <span class="source">${build.folder}</span></h3>
      <p class="bar">${this.progress}${this.share}${this.state}</p>
      ${this.ended}${this.facts}${this.ranks}${this.heard}
    </article>`;
  }

  show(build) {
    if (JSON.stringify(build) === this.shown) return;
    this.shown = JSON.stringify(build);
    this.build = build;
    if (build.state === "running" || build.started !== this.first) this.is_news = true;
    this.progress.value = build.fraction ?? 0;
    this.share.textContent = percent(build.fraction, 2);
    this.state.textContent = stateText(build);
    this.state.className = ["running", "done"].includes(build.state) ? "good" : "bad";
    this.facts.replaceChildren(...facts(build));
    this.ranks.replaceChildren(build.state === "running" ? ranks(build) : "");
    const end = build.state === "running" ? "" : endText(build);
    if (this.ended.dataset.said === end) return;
    this.ended.dataset.said = end;
    this.ended.replaceChildren(end ? html`<p>${end} ${readAnew()}</p>` : "");
  }

  gone() {
    this.is_news = true;
    this.show({ ...this.build, state: "deleted" });
    this.heard.hidden = true;
  }

  // The folder of the dataset whose samples come: of a sweep the variant that was worked on last.
  get dataset() {
    this.variant = /^(.+)\/(modes|samples)\/[^/]+$/.exec(this.build.running?.[0]?.task ?? "")?.[1] ?? this.variant;
    return this.variant ? `${this.folder}/${this.variant}` : this.folder;
  }

  get wants_sounds() {
    const { top, bottom } = this.element.getBoundingClientRect();
    const is_seen = this.element.isConnected && bottom > 0 && top < innerHeight;
    const { state, samples } = this.build;
    return is_seen && state !== "deleted" && samples.done > 0 && samples.done !== this.heard_of && this.shown !== this.failed;
  }

  async hearNewest() {
    const [done, shown] = [this.build.samples.done, this.shown];
    try {
      this.hear(await newest(this.dataset, newest_count));
      this.heard_of = done;
    } catch {
      this.failed = shown; // there is no dataset.json yet, or no folder any more: asked again when there is news
    }
  }

  // Those that are there stay as they are: one may be playing.
  hear(samples) {
    const there = new Map([...this.sounds.children].map((card) => [card.dataset.key, card]));
    const playing = [...there.values()].filter((card) => card.querySelector("audio").currentTime > 0 && !card.querySelector("audio").paused);
    const cards = samples.map((sample) => there.get(sample.key) ?? soundCard(sample, { atOnce: true }));
    samples.forEach((sample, i) => (cards[i].dataset.key = sample.key));
    this.sounds.replaceChildren(...cards, ...playing.filter((card) => !cards.includes(card)));
    this.heard.hidden = samples.length === 0;
  }
}

function stateText(build) {
  if (build.state === "running") return build.remaining_s === null ? "running" : `running, ${seconds(Math.ceil(build.remaining_s))} left`;
  return { done: "done", lost: "killed", deleted: "deleted", error: "ended by an error", interrupted: "interrupted" }[build.state] ?? build.state;
}

function endText(build) {
  if (build.state === "deleted") return "The folder was deleted.";
  if (build.state === "lost") return `There is no word since ${build.updated}: the build was killed, or its node is gone. The same command goes on.`;
  if (build.state === "error") return `It ended by an error: ${build.error ?? "status.json does not say which"}.`;
  if (build.state === "interrupted") return "It was interrupted. The same command goes on.";
  return `It is done after ${seconds(build.elapsed_s)}${build.tasks.failed > 0 ? `, but for ${count(build.tasks.failed, "failed task")}` : ""}.`;
}

function readAnew() {
  const button = html`<button type="button">Read the whole report anew</button>`;
  button.onclick = () => location.reload();
  return html`<span class="buttons">${button}</span>`;
}

// Until samples come their rate is not known, but that of tasks.
function rate(build) {
  if (build.samples_per_s > 0) return `${number(build.samples_per_s)} samples/s`;
  return build.tasks.done > 0 && build.elapsed_s > 0 ? `${number((60 * build.tasks.done) / build.elapsed_s)} tasks/min` : "–";
}

function facts(build) {
  const of = ({ done, all }) => `${done.toLocaleString("en")} of ${all.toLocaleString("en")}`;
  const failed = ["tasks", "objects", "samples"].filter((kind) => build[kind].failed > 0).map((kind) => `${build[kind].failed} ${kind}`);
  const tiles = [
    ["samples", of(build.samples)],
    ["rate", rate(build)],
    ["time left", build.state === "running" && build.remaining_s !== null ? seconds(Math.ceil(build.remaining_s)) : "–"],
    ["since the beginning", seconds(build.elapsed_s)],
    ["objects", of(build.objects)],
    ["tasks", of(build.tasks)],
    ["failed", failed.length > 0 ? failed.join(", ") : "none"],
    ["on disk", bytes(build.bytes)],
  ];
  return tiles.map(([name, value]) => html`<div class=${name === "failed" && failed.length > 0 ? "bad" : ""}><dt>${name}</dt><dd>${value}</dd></div>`);
}

function ranks(build) {
  const busy = new Map((build.running ?? []).map((task) => [task.rank, task]));
  const shown = Array.from({ length: Math.min(build.ranks, max_ranks) }, (_, rank) => busy.get(rank));
  const line = (task) => (task ? html`<code>${task.task}</code>${task.stage ? `, ${task.stage}` : ""}${task.item ? html` <span class="source">${task.item}</span>` : ""}` : "without a task");
  return html`<h4>${count(build.ranks, "rank")} on ${build.host}</h4>
    <ol class="ranks" start="0">${shown.map((task) => html`<li>${line(task)}</li>`)}</ol>
    ${build.ranks > max_ranks ? html`<p class="note">… and ${build.ranks - max_ranks} more, ${busy.size} of all in a task</p>` : ""}`;
}

// Of the builds on the screen in turn.
function askForNewest(cards) {
  let turn = 0;
  const ask = async () => {
    const waiting = document.hidden ? [] : [...cards.values()].filter((card) => card.wants_sounds);
    if (waiting.length > 0) await waiting[turn++ % waiting.length].hearNewest();
    setTimeout(ask, newest_ms);
  };
  ask();
}
