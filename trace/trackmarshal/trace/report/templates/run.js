// Steps through the cycles: a cursor in every plot, the cycle's vehicles in the scene, and its verdicts in words.
(function () {
  "use strict";
  var data = JSON.parse(document.getElementById("run-data").textContent);
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
        var letter = lane.v[i], said = letter === "v" ? (lane.m[i] + " " + rule.unit).trim().replace("-", "−") : letter === "u" ? "undefined" : letter === "o" ? "open" : "";
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

  function show(i) {
    slider.value = i;
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
  slider.addEventListener("input", function () { show(+slider.value); });
  bar.querySelectorAll("button").forEach(function (button) {
    button.addEventListener("click", function () {
      var i = +slider.value;
      if (button.dataset.by === "change") {
        var before = state(i);
        for (i += 1; i < count && state(i) === before; i += 1) { /* on to the next change */ }
        if (i >= count) i = 0;
      } else i = Math.min(count - 1, Math.max(0, i + Number(button.dataset.by)));
      show(i);
    });
  });
  document.querySelectorAll("svg.plot").forEach(function (plot) {
    plot.addEventListener("click", function (event) {
      var box = plot.getBoundingClientRect(), at = plot.dataset;
      var x = (event.clientX - box.left) / box.width * plot.viewBox.baseVal.width;
      var t = +at.t0 + (x - at.x0) / (at.x1 - at.x0) * (at.t1 - at.t0);
      var i = 0;
      while (i + 1 < count && data.t[i + 1] <= t) i += 1;
      show(i);
    });
  });
  bar.hidden = false;
  say(0);
}());
