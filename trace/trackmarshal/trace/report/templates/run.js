// Steps through the cycles: a cursor in every plot, the cycle's vehicles in the scene, its verdicts in words, and the numbers behind them.
(function () {
  "use strict";
  var data = JSON.parse(document.getElementById("run-data").textContent);
  var panel = document.getElementById("cursor"), cards = panel.querySelector(".cards-of");
  var bar = document.getElementById("stepper"), slider = bar.querySelector("input"), words = bar.querySelector("output");
  var space = "http" + "://www.w3.org/2000/svg", count = data.t.length;

  function state(i) {
    return data.decision[i] + data.rules.map(function (rule) {
      return rule.lanes.map(function (lane) { return lane.v[i]; }).join("");
    }).join("");
  }

  function say(i) {
    var found = [];
    data.rules.forEach(function (rule) {
      var parts = {};
      rule.lanes.forEach(function (lane) {
        var letter = lane.v[i], said = letter === "v" ? (lane.m[i] + " " + rule.unit).trim().replace("-", "−") : letter === "u" ? "undefined" : "";
        if (said) (parts[said] = parts[said] || []).push(lane.c);
      });
      Object.keys(parts).forEach(function (said) { found.push(rule.name + " " + said + " (" + (parts[said].length > 1 ? "both" : parts[said][0]) + ")"); });
    });
    var more = found.length > 4 ? " and " + (found.length - 4) + " more" : "";
    words.textContent = data.t[i] + " " + data.unit + " · " + data.decision[i] + " · " + (found.length ? found.slice(0, 4).join(", ") + more : "all safe");
  }

  function shape(group, matrix, name, points, style, closed) {
    var d = points.map(function (p) {
      return (matrix[0] * p[0] + matrix[2] * p[1] + matrix[4]).toFixed(1) + " " + (matrix[1] * p[0] + matrix[3] * p[1] + matrix[5]).toFixed(1);
    });
    if (!d.length) return;
    var path = document.createElementNS(space, "path");
    path.setAttribute("d", "M" + d.join("L") + (closed ? "Z" : ""));
    path.setAttribute("class", style);
    group.appendChild(path);
  }

  function corners(box) {
    var c = Math.cos(box[2]), s = Math.sin(box[2]), l = box[3] / 2, w = box[4] / 2;
    return [[1, 1], [1, -1], [-1, -1], [-1, 1]].map(function (k) {
      return [box[0] + k[0] * l * c - k[1] * w * s, box[1] + k[0] * l * s + k[1] * w * c];
    });
  }

  function pairs(flat) {
    var found = [];
    for (var k = 0; k + 1 < flat.length; k += 2) found.push([flat[k], flat[k + 1]]);
    return found;
  }

  function element(name, style, text) {
    var made = document.createElement(name);
    if (style) made.className = style;
    if (text !== undefined) made.textContent = text;
    return made;
  }

  function both(parts, said, candidate) { (parts[said] = parts[said] || []).push(candidate); }

  function scores(i) {
    var list = element("ul", "numbers");
    data.scores.forEach(function (score) {
      var parts = {};
      score.lanes.forEach(function (lane) {
        var words = {v: "violated", u: "undefined", o: "open", i: "inactive", "-": "no trajectory"}[lane.v[i]] || "";
        var margin = lane.m[i] === null ? "" : String(lane.m[i]).replace("-", "−") + " by " + score.rules[lane.by[i]];
        both(parts, [words, margin].filter(Boolean).join(", ") || "holds", lane.c);
      });
      Object.keys(parts).forEach(function (said) {
        var item = element("li", "", (score.name || "without a requirement") + ": ");
        item.appendChild(element("b", "", said));
        if (parts[said].length < score.lanes.length) item.appendChild(document.createTextNode(" (" + parts[said].join(" and ") + ")"));
        list.appendChild(item);
      });
    });
    return list;
  }

  function told(i) {
    var found = {}, order = [];
    data.told.forEach(function (entry) {
      var at = entry.at[i];
      if (!at) return;
      var key = entry.rule + "\n" + JSON.stringify(at);
      if (!found[key]) { found[key] = {rule: entry.rule, at: at, of: []}; order.push(found[key]); }
      found[key].of.push(entry.c);
    });
    function mild(one) { return one.at[0] === "satisfied" ? 1 : 0; }
    return order.sort(function (a, b) { return mild(a) - mild(b); });
  }

  function card(one) {
    var made = element("section"), head = element("h4", "", one.rule + " "), list = element("ul", "numbers");
    head.appendChild(element("span", "soft", [one.at[0], one.at[1], one.of.join(" and ")].filter(Boolean).join(" · ")));
    made.appendChild(head);
    one.at[2].forEach(function (place) {
      var line = data.lines[place];
      if (!line[1]) { made.appendChild(element("p", "small", line[0])); return; }
      var item = element("li", "", line[0] + " = ");
      item.appendChild(element("b", "", line[1]));
      list.appendChild(item);
    });
    if (list.children.length) made.appendChild(list);
    return made;
  }

  var kept = {};
  data.told.forEach(function (entry) { Object.keys(entry.at).forEach(function (i) { kept[i] = true; }); });
  var stops = Object.keys(kept).map(Number).sort(function (a, b) { return a - b; });

  function numbers(i) {
    var found = told(i);
    var names = found.map(function (one) { return one.rule; }).filter(function (name, k, all) { return all.indexOf(name) === k; });
    var more = names.length > 3 ? " and " + (names.length - 3) + " more" : "";
    panel.querySelector("summary").textContent = "Numbers at the cursor: " + (names.slice(0, 3).join(", ") + more || "margins alone");
    if (!panel.open) return;
    cards.textContent = "";
    var first = element("section");
    first.appendChild(element("h4", "", "Least margin of each requirement (0: the limit, 1: see “what 1 is”)"));
    first.appendChild(scores(i));
    cards.appendChild(first);
    found.forEach(function (one) { cards.appendChild(card(one)); });
    if (!found.length && stops.length) {
      var other = element("p", "small", "Of this cycle no more numbers are kept. Kept are those of unsafe cycles, and of those next to a bound: ");
      [stops.filter(function (k) { return k < i; }).pop(), stops.filter(function (k) { return k > i; })[0]].forEach(function (stop) {
        if (stop === undefined) return;
        var button = element("button", "", data.t[stop] + " " + data.unit);
        button.type = "button";
        button.addEventListener("click", function () { go(stop); });
        other.appendChild(button);
        other.appendChild(document.createTextNode(" "));
      });
      cards.appendChild(other);
    }
    data.told.forEach(function (entry) {
      if (entry.untold) cards.appendChild(element("p", "small soft", entry.rule + ", " + entry.c + ": of " + entry.untold + " more unsafe cycles no numbers are kept; `trackmarshal explain` tells them."));
    });
  }

  var later = 0;
  function write(i) {
    clearTimeout(later);
    later = setTimeout(function () {
      try { history.replaceState(null, "", "#t=" + data.t[i]); } catch (refused) { /* a page that may not: the slider works all the same */ }
    }, 150);
  }

  function go(i) { show(i); write(i); }

  // `#t=12.3`: the last cycle that has begun by then.
  function follow() {
    var asked = /^#t=(-?[0-9.]+(?:e[-+]?[0-9]+)?)$/i.exec(location.hash), i = 0;
    if (!asked || !isFinite(asked[1])) return false;
    while (i + 1 < count && data.t[i + 1] <= +asked[1] + 1e-9) i += 1;
    show(i);
    return true;
  }

  function show(i) {
    slider.value = i;
    numbers(i);
    slider.setAttribute("aria-valuetext", data.t[i] + " " + data.unit);
    say(i);
    document.querySelectorAll("svg.plot").forEach(function (plot) {
      var line = plot.querySelector(".cursor"), at = plot.dataset;
      var x = +at.x0 + (data.t[i] - at.t0) / (at.t1 - at.t0) * (at.x1 - at.x0);
      line.setAttribute("x1", x);
      line.setAttribute("x2", x);
      line.setAttribute("visibility", "visible");
    });
    document.querySelectorAll("svg.scene g.now").forEach(function (group) {
      var matrix = group.ownerSVGElement.dataset.matrix.split(" ").map(Number);
      group.textContent = "";
      group.ownerSVGElement.classList.add("stepping");
      Object.keys(data.paths).forEach(function (name) { shape(group, matrix, name, pairs(data.paths[name][i]), "plan near " + name, false); });
      data.others[i].forEach(function (box) { shape(group, matrix, "other", corners(box), "foot other", true); });
      if (data.ego[i]) {
        shape(group, matrix, "ego", corners(data.ego[i]), "foot ego", true);
        var ring = document.createElementNS(space, "circle"), e = data.ego[i];
        ring.setAttribute("cx", matrix[0] * e[0] + matrix[2] * e[1] + matrix[4]);
        ring.setAttribute("cy", matrix[1] * e[0] + matrix[3] * e[1] + matrix[5]);
        ring.setAttribute("r", 12);
        ring.setAttribute("class", "halo");
        group.appendChild(ring);
      }
    });
  }

  slider.max = count - 1;
  slider.addEventListener("input", function () { go(+slider.value); });
  bar.querySelectorAll(".row button").forEach(function (button) {
    button.addEventListener("click", function () {
      var i = +slider.value;
      if (button.dataset.by === "change") {
        var before = state(i);
        for (i += 1; i < count && state(i) === before; i += 1) { /* on to the next change */ }
        if (i >= count) i = 0;
      } else i = Math.min(count - 1, Math.max(0, i + Number(button.dataset.by)));
      go(i);
    });
  });
  document.querySelectorAll("svg.plot").forEach(function (plot) {
    plot.addEventListener("click", function (event) {
      var box = plot.getBoundingClientRect(), at = plot.dataset;
      var x = (event.clientX - box.left) / box.width * plot.viewBox.baseVal.width;
      var t = +at.t0 + (x - at.x0) / (at.x1 - at.x0) * (at.t1 - at.t0);
      var i = 0;
      while (i + 1 < count && data.t[i + 1] <= t) i += 1;
      go(i);
    });
  });
  panel.addEventListener("toggle", function () { numbers(+slider.value); });
  window.addEventListener("hashchange", follow);
  // On paper everything is open.
  var shut = [];
  window.addEventListener("beforeprint", function () {
    shut = Array.prototype.slice.call(document.querySelectorAll("main details:not([open])"));
    shut.forEach(function (one) { one.open = true; });
  });
  window.addEventListener("afterprint", function () { shut.forEach(function (one) { one.open = false; }); });
  bar.hidden = false;
  if (!follow()) { say(0); numbers(0); }
}());
