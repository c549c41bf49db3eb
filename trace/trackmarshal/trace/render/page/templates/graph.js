// The graph of the page: nodes by their numbers, links by their ends, and what is reached over them.
const data = JSON.parse(document.getElementById("walk-data").textContent);
const where = ([file, line, column]) => (file === undefined ? "" : data.files[file] + (line ? ":" + line : "") + (column ? ":" + column : ""));
const nodes = data.nodes.map(([kind, id, title, place, status, ...said]) => {
  const attributes = {};
  for (let one = 0; one < said.length; one += 2) attributes[data.names[said[one]]] = typeof said[one + 1] === "number" ? data.texts[said[one + 1]] : said[one + 1];
  return { kind: data.kinds[kind][0], id, title, place: where(place), status, said: attributes };
});
const statuses = data.statuses.map(([word, sign, meaning]) => ({ word, sign, meaning }));
const links = data.links.map(([way, source, target, state, place]) => ({ way: data.ways[way], source, target, state: data.states[state], place }));
// What lies one link below a node and above it, and all links at it, in order.
const below = nodes.map(() => []), above = nodes.map(() => []), touching = nodes.map(() => []);
links.forEach((link, number) => {
  touching[link.source].push(number);
  if (typeof link.target !== "number") return;
  if (link.target !== link.source) touching[link.target].push(number);
  if (link.state !== "covers" && link.state !== "outdated") return; // such a link leads nowhere
  const [under, over] = link.way[2] ? [link.target, link.source] : [link.source, link.target];
  below[over].push(under);
  above[under].push(over);
});
const byKind = new Map(data.kinds.map(([kind]) => [kind, []]));
nodes.forEach((node, number) => byKind.get(node.kind).push(number));
const cellsOf = new Map(data.rows.map(([number], row) => [number, data.cells[row]]));
const depthOf = new Map(data.rows);
const key = (number) => nodes[number].kind + ":" + nodes[number].id;
const numbers = new Map(nodes.map((_, number) => [key(number), number]));
// Requirements in the order of the matrix, those that are demanded no longer behind them.
byKind.set("requirement", [...new Set([...depthOf.keys(), ...byKind.get("requirement")])]);

// All that is reached from some nodes, going on below (or above), nearest first; they themselves are in it.
function reached(from, steps) {
  const found = new Set(from);
  for (const number of found) steps[number].forEach((other) => found.add(other)); // grows while it is read
  return found;
}

// The nodes of a kind that one leads to: all links down, then all links up.
function leads(number, kind) {
  const found = new Set([...reached([number], below), ...reached([number], above)]);
  found.delete(number);
  return [...found].filter((other) => nodes[other].kind === kind);
}

// The nodes that lead to some of these.
function leading(goals) {
  return new Set([...reached(goals, above), ...reached(goals, below)]);
}

// The kinds that nodes of a kind may lead to.
const beyond = (() => {
  const steps = [below, above].map((by) => {
    const found = new Map(data.kinds.map(([kind]) => [kind, new Set()]));
    by.forEach((others, number) => others.forEach((other) => found.get(nodes[number].kind).add(nodes[other].kind)));
    return found;
  });
  return (kind) => {
    const all = new Set();
    steps.forEach((by) => {
      const found = new Set(by.get(kind));
      for (const other of found) by.get(other).forEach((next) => found.add(next));
      found.forEach((other) => all.add(other));
    });
    return data.kinds.map(([other]) => other).filter((other) => all.has(other));
  };
})();
