// Cards: all that is known of one node, made when it is asked for. Whatever comes from the project goes in as text.
function make(tag, given, ...inside) {
  const element = document.createElement(tag);
  Object.entries(given || {}).forEach(([name, value]) => element.setAttribute(name, value));
  element.append(...inside.flat().filter((part) => part !== null && part !== ""));
  return element;
}

// Text in which backquotes mark code; a backquote without its partner is one.
function marked(text) {
  const parts = text.split("`");
  return parts.length % 2 ? parts.map((part, number) => (number % 2 ? make("code", {}, part) : part)) : [text];
}

// A formula. It was made of escaped text; anything but MathML is shown as text all the same.
function math(source) {
  const held = make("template");
  held.innerHTML = source;
  const all = [...held.content.querySelectorAll("*")];
  const fine = all.every((one) => one.namespaceURI.endsWith("/Math/MathML") && ![...one.attributes].some(({ name }) => /^on|href|src/.test(name)));
  return fine ? held.content : make("code", {}, source);
}

const chip = (status, text) =>
  status < 0 ? null : make("span", { class: "chip is-" + statuses[status].word }, statuses[status].sign + " " + (text || statuses[status].word));
const place = (text) => (text ? make("span", { class: "place" }, text) : null);
const heading = (text) => make("h4", {}, text);
const short = (text) => (text.length > 60 ? text.slice(0, 59) + "…" : text);

// A link to a node's card; the view stays as it is.
function to(number, more) {
  const { kind, id, title, status } = nodes[number];
  const said = ["test", "person"].includes(kind) ? title || id : id;
  const made = make("a", { href: address({ at: key(number) }), class: "to", title: [kind, id, title].filter(Boolean).join(" ") }, more === "plain" ? said : short(said));
  return status < 0 || more === "plain" ? made : make("span", { class: "with" }, make("span", { class: "mark is-" + statuses[status].word, title: statuses[status].word }, statuses[status].sign), made);
}

function several(found, most, all) {
  const shown = found.slice(0, most).map((number) => to(number));
  if (found.length > most) shown.push(make("a", { class: "to more", href: all }, "all " + found.length));
  return make("span", { class: "several" }, shown);
}

function facts(pairs) {
  const shown = pairs.filter(([, value]) => value !== null && value !== "" && value !== undefined);
  return shown.length ? make("dl", { class: "facts" }, shown.flatMap(([label, value]) => [make("dt", {}, label), make("dd", {}, value)])) : null;
}

function table(head, rows) {
  const line = (cells, tag) => make("tr", {}, cells.map((cell, number) => make(tag, tag === "td" ? { "data-label": head[number] } : {}, cell)));
  return make("div", { class: "wide" }, make("table", { class: "small" }, make("thead", {}, line(head, "th")), make("tbody", {}, rows.map((row) => line(row, "td")))));
}

function folded(title, open, ...inside) {
  return make("details", open ? { open: "" } : {}, make("summary", {}, title), ...inside);
}

const PROSE = ["statement", "situation", "description", "rationale"], LONG = ["fingerprint", "sha256"];
const EVIDENCE = { test: "test", run: "run", fault: "fault" };

function card(number) {
  const node = nodes[number];
  const made = make("article", { class: "card", "data-node": key(number) }, title(number));
  const said = Object.entries(node.said).filter(([name]) => !PROSE.includes(name));
  PROSE.forEach((name) => node.said[name] && made.append(make("p", { class: name }, node.said[name])));
  made.append(facts([
    ...said.map(([name, value]) => [name.replace(/_/g, " "), LONG.includes(name) ? make("code", {}, value) : marked(value)]),
    [node.place ? "declared" : "", place(node.place)],
  ]) || "");
  [runs, rule, spoken, cells, along, evidence, findings, all].forEach((part) => made.append(...(part(number) || []).filter(Boolean)));
  return made;
}

function title(number) {
  const { kind, id, title: words, status } = nodes[number];
  return make("header", {}, make("p", { class: "kind" }, kind), make("h3", {}, make("b", {}, kind === "test" ? words || id : id), " ", kind === "test" ? make("span", { class: "soft" }, id.slice(0, id.indexOf(":"))) : words, " ", chip(status) || ""),
    make("p", { class: "tools" }, make("a", { href: address({ at: key(number), kind: "", to: "", from: "", stage: "", asil: "", status: "", q: "", gap: "", cell: "" }) }, "link to this"), " · ",
      make("a", { href: address({ at: "", cell: "" }), class: "close" }, "close")));
}

// Rules: formula, words, parameters in force, and the text of the spec.
function rule(number) {
  const sheet = data.rules[number];
  if (!sheet) return ["rule", "assumption"].includes(nodes[number].kind) ? [command(number)] : null;
  const parts = [];
  if (sheet.clauses) {
    parts.push(heading("formula"), ...sheet.clauses.map(([kind, depth, beside, formula]) =>
      make("div", { class: "clause " + kind, style: "--depth: " + depth }, make("span", { class: "word" }, WORDS[kind] || ""), math(formula), beside ? make("span", { class: "soft" }, beside) : null)));
    if (sheet.definitions || sheet.machines || sheet.tables || sheet.places) parts.push(make("p", { class: "soft" }, "where"));
    (sheet.definitions || []).forEach((formula) => parts.push(make("div", { class: "clause", style: "--depth: 1" }, math(formula))));
    (sheet.machines || []).forEach(([head, states, start, moves]) => parts.push(
      make("p", {}, math(head), ": " + states.join(", ") + "; starts as " + start),
      table(["becomes", "from", "when", "remembers"], moves.map(([target, sources, when, kept]) => [target, sources.join(", "), math(when), kept.map(math)]))));
    (sheet.tables || []).forEach(([name, way, rows]) => parts.push(make("p", {}, make("code", {}, name), `: ${way}`), table(rows[0], rows.slice(1))));
    (sheet.places || []).forEach(([name, kind, points]) => parts.push(make("p", {}, kind + " ", make("code", {}, name), ", " + points + " points")));
  }
  parts.push(...(drawing(number) ? [drawing(number)] : undrawn(number, sheet)));
  if (sheet.words) parts.push(heading("in words"), ...[...sheet.words.demand, ...sheet.words.definitions].map((text) => make("p", {}, text)));
  if (sheet.parameters) {
    parts.push(heading("parameters in force"), table(["parameter", "value", "range", "source"], sheet.parameters.map(([name, , value, range, from]) => {
      const own = numbers.get("parameter:" + name);
      return [own === undefined ? name : to(own), value, range, from];
    })));
  }
  if (sheet.inputs) parts.push(facts([["reads", sheet.inputs.map(([name, unit]) => name + (unit ? " (" + unit + ")" : "")).join(", ")]]));
  if (sheet.spec) parts.push(folded("spec, " + nodes[number].place, true, make("pre", {}, sheet.spec)));
  return [...parts, command(number)];
}

// Where a rule ceases to be met, with its tests: as an image, in which no script runs.
function drawing(number) {
  const source = data.drawings[number];
  return source ? make("img", { class: "drawing", src: "data:image/svg+xml," + encodeURIComponent(source), alt: "where " + nodes[number].id + " ceases to be met" }) : null;
}

// Why there is no drawing of a rule, or how to come by it: nothing is drawn for this page, as that takes long.
function undrawn(number, sheet) {
  const said = data.undrawn[number];
  if (said || !sheet.clauses) return [said ? make("p", { class: "soft" }, said) : null];
  return [make("p", { class: "soft" }, ...marked("No drawing of what is there now is kept: `trackmarshal show " + nodes[number].id + " --draw` draws it, `trackmarshal case` all."))];
}

// The lines of a test, and the drawing that it stands in.
function spoken(number) {
  const text = data.tests[number];
  return text ? [heading("test, " + nodes[number].place), make("pre", {}, text), ...above[number].map(drawing)] : null;
}

// Where a run came to what: its page at the second at which a rule was violated first.
function second(run, time) {
  const page = data.runs[run].page;
  return page ? make("a", { href: page + (time === null ? "" : "#t=" + time), class: "page" }, time === null ? "page of the run" : "at " + time + " s") : time === null ? "" : "at " + time + " s";
}

function runs(number) {
  const node = nodes[number];
  if (node.kind === "run" && data.runs[number]) {
    const { rules, truths, page, overrides } = data.runs[number];
    const rows = rules.map(([of, name, first, counts]) => [
      of < 0 ? name : to(of), first === null ? "never" : second(number, first),
      Object.entries(counts).map(([who, said]) => who + ": " + Object.entries(said).map(([what, times]) => times + " " + what).join(", ")).join("; "),
    ]);
    return [page ? make("p", {}, second(number, null)) : make("p", { class: "soft" }, "`trackmarshal assess` draws this run."),
      facts([...truths.map(([kind, inside]) => ["ground truth, " + kind, inside ? "inside" : "outside"]), ["in place of the spec's values", overrides.join("; ")]]),
      folded(rules.length + " rules in this run", false, table(["rule", "first violated", "evaluations"], rows))];
  }
  if (!["requirement", "rule", "assumption", "scenario"].includes(node.kind)) return null;
  const own = new Set(leads(number, "rule").concat(leads(number, "assumption"), number));
  const rows = leads(number, "run").filter((run) => data.runs[run]).map((run) => {
    const times = data.runs[run].rules.filter(([of, , first]) => own.has(of) && first !== null).map(([, , first]) => first);
    return [to(run), times.length ? second(run, Math.min(...times)) : second(run, null) || "", times.length ? "first violated" : "not violated"];
  });
  return rows.length ? [folded(rows.length + (rows.length === 1 ? " run" : " runs"), rows.length < 8, table(["run", "page", "its rules"], rows))] : null;
}

// The cells of a requirement, down to what counts in them.
function cells(number) {
  return (cellsOf.get(number) || []).flatMap(([stage, status, items]) => [
    make("h4", { id: "cell-" + data.stages[stage].id, class: "stage" }, chip(status), " ", make("b", {}, data.stages[stage].id), " " + data.stages[stage].title),
    make("p", { class: "soft" }, data.stages[stage].shows),
    items.length ? folded(items.length + (items.length === 1 ? " item" : " items"), items.length < 7 || statuses[status].word !== "covered", make("ul", { class: "items" }, items.map(item)))
      : make("p", { class: "soft" }, "There is nothing that counts here."),
  ]);
}

function item([status, detail, node, kind, name, words, at]) {
  const what = node < 0 ? [kind + " ", make("code", {}, name), " " + words] : [nodes[node].kind + " ", to(node, "plain"), ["test", "waiver"].includes(nodes[node].kind) ? "" : " " + nodes[node].title];
  return make("li", {}, chip(status), make("div", {}, make("p", {}, what), detail && detail !== "passed" ? make("p", { class: "soft" }, marked(detail)) : null,
    make("p", {}, place(node < 0 ? where(at) : nodes[node].place))));
}

// What lies below and above, by kind.
function along(number) {
  return [["below", below, "what answers for it, over all links down"], ["above", above, "what it answers for, over all links up"]].flatMap(([word, steps, said]) => {
    const found = reached([number], steps);
    found.delete(number);
    const named = data.kinds.filter(([kind]) => kind !== "result" || nodes[number].kind === "test"); // a result is its test's
    const groups = named.map(([kind]) => [kind, [...found].filter((other) => nodes[other].kind === kind)]).filter(([, members]) => members.length);
    return groups.length ? [make("h4", { class: word, title: said }, word), facts(groups.map(([kind, members]) =>
      [kind + " (" + members.length + ")", several(members, 12, address({ kind, from: key(number), to: "", stage: "", asil: "", status: "", q: "", gap: "", cell: "" }))]))] : [];
  });
}

// The entry of the evidence store, and the command that makes it again.
function evidence(number) {
  const held = data.evidence[number], kind = nodes[number].kind;
  if (!(kind in EVIDENCE)) return null;
  if (!held) return [make("p", { class: "soft" }, "The evidence store has no entry of it."), command(number)];
  const [id, made, maker, from] = held, [tool, commit, platform] = data.makers[maker];
  return [heading("evidence"), facts([["entry", make("code", {}, id)], ["made", made], ["tool", tool], ["commit", commit], ["on", platform]]),
    folded("made from " + from.length + " inputs", false, make("p", {}, make("code", {}, from.join(", ")))), command(number)];
}

function command(number) {
  const { kind, id } = nodes[number], quoted = (text) => (/^[\w./:@+-]+$/.test(text) ? text : "'" + text.replace(/'/g, "'\\''") + "'");
  const said = { test: "trackmarshal test", run: "trackmarshal replay " + quoted(id), fault: "trackmarshal trace --rerun", rule: "trackmarshal show " + quoted(id), assumption: "trackmarshal show " + quoted(id) }[kind];
  return facts([[{ rule: "more", assumption: "more" }[kind] || "again", make("code", {}, said)]]);
}

// What was found about it, as it stands further down on the page.
function findings(number) {
  const found = (findingsOf.get(number) || []).map((one) => {
    const copy = document.getElementById("finding-" + one).cloneNode(true);
    copy.removeAttribute("id");
    copy.querySelectorAll("details").forEach((following) => following.remove());
    return copy;
  });
  return found.length ? [heading("findings"), make("ul", { class: "findings" }, found)] : null;
}

// Every link at the node, whatever its state, where it is written.
function all(number) {
  const rows = touching[number].map((one) => {
    const link = links[one], out = link.source === number;
    const end = out ? (typeof link.target === "number" ? to(link.target) : make("span", {}, link.target.join(" "))) : to(link.source);
    return [out ? link.way[0] : link.way[1], end, link.state === "covers" ? "" : link.state, place(where(link.place))];
  });
  return [rows.length ? folded(rows.length + (rows.length === 1 ? " link" : " links"), false, table(["link", "with", "state", "written at"], rows)) : make("p", { class: "soft" }, "Nothing is linked with it.")];
}

const WORDS = data.words;
const findingsOf = new Map();
data.findings.forEach((about, one) => about.forEach((number) => findingsOf.set(number, [...(findingsOf.get(number) || []), one + 1])));
