// State: the controls. It stands in the URL, so that a link shows the same page.
const byId = (id) => document.getElementById(id);
const controls = [...document.querySelectorAll(".controls select, .controls input")];
const status = byId("status");
const questions = ["heating", "range", "efficiency"];
let turn = 0;
let waiting = 0;
let worker;

const number = (id) => Number(byId(id).value);
const gait = () => ({
  activity: byId("activity").value,
  joint: byId("joint").value,
  body_mass: number("body_mass"),
  support: number("support"),
  ratio: number("ratio"),
  stiffness: number("stiffness"),
});
const loads = {
  torque: () => ({ torque: number("torque") }),
  current: () => ({ current: number("current") }),
  gait: () => ({ gait: gait() }),
};
const choice = () => ({
  motor: byId("motor").value,
  cooling: byId("cooling").value,
  fan: number("fan"),
  ambient: number("ambient"),
  voltage: number("voltage"),
  speed: number("speed"),
  minutes: number("minutes"),
  load: loads[byId("load").value](),
});

function showLoad() {
  const load = byId("load").value;
  for (const part of document.querySelectorAll("[data-load]")) {
    part.hidden = !part.dataset.load.split(" ").includes(load);
  }
}

function readUrl() {
  const state = new URLSearchParams(location.hash.slice(1));
  let known = 0;
  for (const control of controls) {
    if (state.has(control.id)) {
      control.value = state.get(control.id);
      known += 1;
    }
  }
  return known;
}

function writeUrl() {
  const state = new URLSearchParams(controls.map((control) => [control.id, control.value]));
  history.replaceState(null, "", "#" + state);
}

// A control that is no number in its limits is named; nothing is computed.
function invalid() {
  const wrong = controls.find((c) => c.closest("[hidden]") === null ? !c.checkValidity() || c.value === "" && c.id !== "cooling" : false);
  if (wrong) {
    const label = document.querySelector("label[for=" + wrong.id + "]").textContent;
    status.textContent = label + ": " + (wrong.validationMessage || "a value is missing");
  }
  return wrong !== undefined;
}

function ask(question) {
  waiting += 1;
  worker.postMessage({ turn, request: { question, choice: choice() } });
}

function begin() {
  turn += 1;
  waiting = 0;
  document.documentElement.dataset.state = "computing";
  writeUrl();
  if (invalid()) {
    document.documentElement.dataset.state = "invalid";
    return false;
  }
  status.textContent = "Computing";
  return true;
}

function compute() {
  if (begin()) questions.forEach(ask);
}

// Another motor: a load that suits its size.
function suggest() {
  if (begin()) ask("suggestion");
}

function show({ turn: of, question, answer, seconds }) {
  if (of !== turn) return;
  waiting -= 1;
  if (question === "suggestion") {
    if (answer.values) {
      byId("torque").value = answer.values.torque.toPrecision(3);
      byId("current").value = answer.values.current.toPrecision(3);
    }
    compute();
    return;
  }
  const place = byId(question);
  place.querySelector(".text").textContent = answer.error || answer.text;
  place.querySelector(".figure").innerHTML = answer.error ? "" : answer.figure;
  place.querySelector(".values").textContent = answer.error ? "" : JSON.stringify(answer.values);
  place.dataset.seconds = seconds.toFixed(3);
  if (waiting === 0) {
    status.textContent = "Ready";
    document.documentElement.dataset.state = "ready";
  }
}

function start(known) {
  const source = byId("worker").textContent;
  worker = new Worker(URL.createObjectURL(new Blob([source], { type: "text/javascript" })));
  worker.onmessage = ({ data }) => (data.ready ? (known ? compute() : suggest()) : show(data));
  worker.onerror = (event) => {
    status.textContent = "The computation stopped: " + event.message;
    document.documentElement.dataset.state = "failed";
    worker.terminate();
  };
  worker.postMessage({ wasm: byId("models").textContent.trim() });
}

let timer;
for (const control of controls) {
  control.addEventListener("input", () => {
    clearTimeout(timer);
    showLoad();
    timer = setTimeout(control.id === "motor" ? suggest : compute, 250);
  });
}
document.querySelector(".controls").addEventListener("submit", (event) => event.preventDefault());
addEventListener("hashchange", () => { readUrl(); showLoad(); compute(); });
const known = readUrl();
showLoad();
start(known);
