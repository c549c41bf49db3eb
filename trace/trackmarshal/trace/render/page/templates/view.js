// The view: which nodes are shown, against what, by which filters. All of it stands in the fragment of the address, so that a view can be linked.
const FIELDS = ["kind", "to", "stage", "asil", "status", "q", "from", "gap", "at", "cell"];
const FIRST = 200, MORE = 500, PRINTED = 300;
// What a kind is held against, where nothing is chosen; requirements are held against stages.
const USUAL = { rule: "requirement", assumption: "requirement", test: "rule", parameter: "rule", run: "requirement", scenario: "requirement", fault: "requirement", document: "requirement", person: "requirement" };
const form = document.getElementById("view"), count = document.getElementById("count"), body = document.getElementById("rows"), pinned = document.getElementById("at"), further = document.getElementById("further");
let state = {}, window_ = FIRST, printing = false;

function read() {
  const said = new URLSearchParams(location.hash.slice(1));
  const found = Object.fromEntries(FIELDS.map((name) => [name, said.get(name) || ""]));
  if (!byKind.has(found.kind)) found.kind = "requirement";
  // What is asked for is answered, too, where nothing leads there: another question's rows would stand for it.
  if (!byKind.has(found.to)) found.to = found.kind === "requirement" ? "" : beyond(found.kind).includes(USUAL[found.kind]) ? USUAL[found.kind] : beyond(found.kind)[0] || "";
  return found;
}

// The fragment of the present view with some of it changed.
function address(changed) {
  const said = new URLSearchParams();
  FIELDS.forEach((name) => {
    const value = name in changed ? changed[name] : state[name];
    if (value && !(name === "kind" && value === "requirement")) said.set(name, value);
  });
  return "#" + (said.toString() || "view=all");
}

// What is searched in: all texts of a node, those of its rule or test among them.
const texts = new Map();
function text(number) {
  if (!texts.has(number)) {
    const { kind, id, title, place, said } = nodes[number], sheet = data.rules[number] || {};
    texts.set(number, [kind, id, title, place, ...Object.values(said), sheet.spec || "", data.tests[number] || ""].join("\n").toLowerCase());
  }
  return texts.get(number);
}

function chosen() {
  const { kind, to, stage, asil, status, q, from, gap } = state;
  let found = byKind.get(kind);
  const keep = (set) => (found = found.filter((number) => set.has(number)));
  const place = data.stages.findIndex((one) => one.id === stage), word = statuses.findIndex((one) => one.word === status);
  if (from && numbers.has(from)) keep(leading([numbers.get(from)]));
  if (asil) keep(new Set([...nodes.keys()].filter((number) => nodes[number].said.asil === asil).concat(kind === "requirement" ? [] : [...reached(byKind.get("requirement").filter((number) => nodes[number].said.asil === asil), below)])));
  if (place >= 0 && kind !== "requirement") keep(at(place));
  const fits = ([of, own]) => (place < 0 || of === place) && (word < 0 || own === word);
  if (kind === "requirement") {
    if (place >= 0 || word >= 0) found = found.filter((number) => (cellsOf.get(number) || []).some(fits));
  } else if (word >= 0) found = found.filter((number) => nodes[number].status === word);
  q.toLowerCase().split(/\s+/).filter(Boolean).forEach((part) => (found = found.filter((number) => text(number).includes(part))));
  if (gap && to) {
    const led = leading(byKind.get(to));
    found = found.filter((number) => !led.has(number) || (kind === to && !leads(number, to).length));
  }
  return found;
}

// The nodes that count in cells of a stage, or say that they belong to it.
function at(place) {
  const found = new Set([...nodes.keys()].filter((number) => nodes[number].said.stage === data.stages[place].id));
  data.cells.forEach((own) => own.forEach(([stage, , items]) => stage === place && items.forEach(([, , node]) => node >= 0 && found.add(node))));
  return found;
}

function options(name, values, none) {
  const select = form.elements[name];
  select.replaceChildren(...(none === null ? [] : [make("option", { value: "" }, none)]), ...values.map(([value, said]) => make("option", { value }, said)));
  select.value = state[name];
  select.disabled = !values.length;
}

function controls(found) {
  const { kind, to } = state;
  options("kind", data.kinds.filter(([one]) => byKind.get(one).length).map(([one]) => [one, one + " (" + byKind.get(one).length + ")"]), null);
  options("to", [...new Set([...beyond(kind), ...(to ? [to] : [])])].map((one) => [one, one]), kind === "requirement" ? "stages" : null);
  options("stage", data.stages.map(({ id, title }) => [id, id + " " + title]), "every stage");
  options("asil", [...new Set(nodes.map(({ said }) => said.asil).filter(Boolean))].sort().map((one) => [one, "ASIL " + one]), "every ASIL");
  options("status", statuses.map(({ word, sign }) => [word, sign + " " + word]), "every status");
  if (document.activeElement !== form.elements.q) form.elements.q.value = state.q;
  form.elements.gap.checked = Boolean(state.gap);
  form.elements.gap.closest("label").hidden = !to;
  form.elements.gap.nextElementSibling.textContent = "only what leads to no " + to;
  const under = document.getElementById("under");
  under.replaceChildren(...(state.from && numbers.has(state.from) ? ["along the links of ", make("a", { href: address({ at: state.from }) }, state.from), " ", make("a", { href: address({ from: "" }) }, "✕ everywhere")] : []));
  count.textContent = found.length.toLocaleString("en") + " of " + byKind.get(kind).length.toLocaleString("en") + " " + kind + (byKind.get(kind).length === 1 ? "" : "s") + tally(found);
}

// Of requirements: how many cells have which status.
function tally(found) {
  if (state.kind !== "requirement") return "";
  const stage = data.stages.findIndex((one) => one.id === state.stage), all = statuses.map(() => 0);
  found.forEach((number) => (cellsOf.get(number) || []).forEach(([of, status]) => (stage < 0 || stage === of) && (all[status] += 1)));
  const said = statuses.map(({ word, sign }, one) => all[one] && all[one].toLocaleString("en") + " " + sign + " " + word).filter(Boolean);
  return said.length ? "; cells: " + said.join(", ") : "";
}

function head() {
  const stages = state.to ? [make("th", {}, "leads to " + state.to)] : data.stages.map(({ id, title, shows }) => make("th", { title: shows }, id, make("small", {}, title)));
  return make("tr", {}, make("th", {}, state.kind), stages);
}

function row(number) {
  const node = nodes[number], open = state.at === key(number);
  const name = make("th", { scope: "row", class: "name", style: "--depth: " + (depthOf.get(number) || 0) },
    make("a", { href: address({ at: open ? "" : key(number), cell: "" }), "aria-expanded": open }, make("b", {}, node.kind === "test" ? node.title || node.id : node.id), " ", node.kind === "test" ? make("span", { class: "soft" }, node.id.slice(0, node.id.indexOf(":"))) : node.title),
    node.said.status === "obsolete" ? make("span", { class: "soft" }, " obsolete") : null,
    node.said.asil ? make("span", { class: "soft asil" }, " ASIL " + node.said.asil) : null, state.kind === "requirement" && !state.to ? null : [" ", chip(node.status) || ""]);
  const made = make("tr", { class: open ? "row open" : "row", "data-node": key(number) }, name, state.to ? make("td", { class: "many" }, led(number)) : stages(number));
  return made;
}

function led(number) {
  const found = leads(number, state.to);
  return found.length ? several(found, 12, address({ kind: state.to, from: key(number), to: "", stage: "", asil: "", status: "", q: "", gap: "", at: "", cell: "" })) : make("span", { class: "soft" }, "nothing leads to a " + state.to);
}

function stages(number) {
  const own = new Map((cellsOf.get(number) || []).map(([stage, status, items]) => [stage, [status, items]]));
  return data.stages.map(({ id }, stage) => {
    if (!own.has(stage)) return make("td", { class: "none" }, "–");
    const { word, sign } = statuses[own.get(stage)[0]];
    return make("td", { "data-label": id }, make("a", { class: "cell is-" + word, href: address({ at: key(number), cell: id }), title: id + ": " + word + ", " + own.get(stage)[1].length + " items" }, sign + " " + word));
  });
}

function render() {
  const found = chosen(), here = numbers.get(state.at);
  const shown = found.slice(0, printing ? found.length : window_);
  const wide = state.to ? 2 : data.stages.length + 1;
  const opened = (number) => make("tr", { class: "opened" }, make("td", { colspan: wide }, card(number)));
  controls(found);
  pinned.replaceChildren(...(here !== undefined && !shown.includes(here) ? [card(here)] : state.at && here === undefined ? [make("p", {}, "Nothing here is called " + state.at + ".")] : []));
  body.tHead.replaceChildren(head());
  body.className = state.to ? "matrix pairs" : "matrix";
  body.tBodies[0].replaceChildren(...shown.flatMap((number) => (number === here || (printing && found.length <= PRINTED) ? [row(number), opened(number)] : [row(number)])));
  further.hidden = shown.length === found.length;
  further.textContent = "show " + Math.min(MORE, found.length - shown.length) + " more";
  if (printing) document.querySelectorAll(".card details").forEach((one) => (one.open = true));
}

// What Escape closed: its row has the focus again once the page is without it, which is later than the key.
let closing = "";

function follow(event) {
  if (event && location.hash && !location.hash.includes("=")) return; // a place on this page
  state = read();
  window_ = FIRST;
  render();
  if (closing) [...document.querySelectorAll("tr.row")].find((one) => one.dataset.node === closing)?.querySelector("a").focus();
  closing = "";
  if (!location.hash) return;
  const target = (state.cell && document.getElementById("cell-" + state.cell)) || (state.at && document.querySelector(".card")) || (event && document.getElementById("matrix"));
  if (target) target.scrollIntoView({ block: "start" });
}

form.addEventListener("input", (event) => {
  const { name, type, checked, value } = event.target;
  state = { ...state, [name]: type === "checkbox" ? (checked ? "1" : "") : value, cell: "" };
  if (name === "kind") state = { ...state, to: "", gap: "" };
  history.replaceState(null, "", address({}));
  state = read();
  window_ = FIRST;
  render();
});
form.addEventListener("submit", (event) => event.preventDefault());
further.addEventListener("click", () => {
  window_ += MORE;
  render();
});
document.addEventListener("keydown", (event) => {
  const typing = /^(input|select|textarea)$/i.test(event.target.tagName);
  if (event.key === "/" && !typing) {
    event.preventDefault();
    form.elements.q.focus();
  } else if (event.key === "Escape" && state.at) {
    closing = state.at;
    location.hash = address({ at: "", cell: "" });
  }
});
window.addEventListener("hashchange", follow);
// On paper nothing can be opened: all rows of the view are there, and all details are open.
let closed = [];
window.addEventListener("beforeprint", () => {
  printing = true;
  closed = [...document.querySelectorAll("details:not([open])")];
  closed.forEach((one) => (one.open = true));
  render();
});
window.addEventListener("afterprint", () => {
  printing = false;
  closed.forEach((one) => (one.open = false));
  render();
});
form.hidden = false;
body.hidden = false;
follow(null);
