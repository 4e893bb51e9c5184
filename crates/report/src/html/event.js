// Lets the first plot be read off, zoomed and moved. The page is complete without it. No sign that
// markup would take for its own stands here.
(async function () {
  "use strict";
  const figure = document.getElementById("event");
  const block = document.getElementById("event-data");
  const table = document.getElementById("series");
  if (!figure) return;
  if (!block) return;
  const svg = figure.querySelector("svg");
  const drawn = svg.querySelector(".drawn");
  const data = JSON.parse(block.textContent);
  const bar = document.createElement("div");
  bar.className = "live";
  figure.insertBefore(bar, svg.nextSibling);

  function link(href) {
    const a = document.createElement("a");
    a.href = href;
    a.download = "series.csv";
    a.textContent = "Download series";
    bar.append(a);
  }
  // A page that is served fetches its samples; in others they are text.
  const from = table.dataset.from;
  const csv = from ? await (await fetch(from)).text() : table.textContent;
  if (csv.length === 0) {
    // Too long for the page: it stands beside it.
    link("series.csv");
    return;
  }

  const rows = csv.trim().split("\n").slice(1);
  const width = rows[0].split(",").length;
  const columns = Array.from({ length: width }, () => new Float64Array(rows.length));
  rows.forEach((row, i) => row.split(",").forEach((cell, k) => { columns[k][i] = Number(cell); }));
  const time = columns[0];
  const last = time.length - 1;

  let view = data.view.slice();
  let whole = false;
  let cursor = null;
  let second = null;
  let band = null;
  const hidden = new Set();

  const x = (t) => data.left + (t - view[0]) / (view[1] - view[0]) * (data.right - data.left);
  const instant = (at) => view[0] + (at - data.left) / (data.right - data.left) * (view[1] - view[0]);
  const hold = (value, low, high) => Math.min(Math.max(value, low), high);

  // The first sample at or after an instant.
  function index(t) {
    let low = 0;
    let high = last;
    while (high > low) {
      const middle = (low + high) >> 1;
      if (time[middle] >= t) high = middle; else low = middle + 1;
    }
    return low;
  }
  function nearest(t) {
    const at = index(t);
    if (at === 0) return 0;
    return t - time[at - 1] > time[at] - t ? at : at - 1;
  }

  function element(parent, name, attributes, text) {
    const made = document.createElementNS(svg.namespaceURI, name);
    for (const key in attributes) made.setAttribute(key, attributes[key]);
    if (text !== undefined) made.textContent = text;
    parent.append(made);
    return made;
  }
  const line = (parent, kind, x1, y1, x2, y2) =>
    element(parent, "line", { class: kind, x1: x1, y1: y1, x2: x2, y2: y2 });

  function shown(value, step) {
    const decimals = hold(Math.ceil(-Math.log10(step) - 1e-9), 0, 9);
    return value.toFixed(decimals).replace("-", "\u2212");
  }
  function ticks(low, high, count) {
    const rough = (high - low) / count;
    const power = Math.pow(10, Math.floor(Math.log10(rough)));
    const part = rough / power;
    const step = power * (1.5 > part ? 1 : 3.5 > part ? 2 : 7.5 > part ? 5 : 10);
    const found = [];
    for (let k = Math.ceil(low / step); high >= k * step; k += 1) {
      found.push({ value: k * step, text: shown(k * step + 0, step) });
    }
    return found;
  }

  function range(panel, own, from, to) {
    let low = 0;
    let high = 0;
    panel.curves.forEach((curve) => {
      if (hidden.has(curve.column)) return;
      for (let i = from; to >= i; i += 1) {
        const value = columns[curve.column][i] * panel.factor;
        if (low > value) low = value;
        if (value > high) high = value;
      }
    });
    if (own === data.panels.length - 1) {
      if (data.bar) high = Math.max(high, data.bar.high);
      high = whole ? Math.max(high, 1.2 * data.limit) : hold(high, 1.2 * data.limit, 4 * data.limit);
      if (!whole) low = Math.max(low, -0.5 * data.limit);
    }
    const room = 0.06 * Math.max(high - low, 1e-9);
    return [low - room, high + room];
  }

  // Returns the path of a curve: at most four points for each unit across.
  function path(values, factor, y, from, to) {
    const parts = [];
    let i = from;
    const each = Math.max(1, Math.floor((to - from) / 1500));
    while (to >= i) {
      const end = Math.min(i + each - 1, to);
      let low = i;
      let high = i;
      for (let k = i; end >= k; k += 1) {
        if (values[low] > values[k]) low = k;
        if (values[k] > values[high]) high = k;
      }
      Array.from(new Set([i, Math.min(low, high), Math.max(low, high), end])).forEach((k) => {
        parts.push(x(time[k]).toFixed(2) + " " + hold(y(values[k] * factor), -1e5, 1e5).toFixed(2));
      });
      i = end + 1;
    }
    return "M" + parts.join("L");
  }

  // The part of a mark that is in view, if any.
  function inView(mark) {
    const start = Math.max(mark.start, view[0]);
    const end = Math.min(mark.end, view[1]);
    return start > end ? null : [start, end];
  }

  const scales = [];
  function draw() {
    drawn.textContent = "";
    scales.length = 0;
    const from = Math.max(index(view[0]) - 1, 0);
    const to = Math.min(index(view[1]) + 1, last);
    const top = data.panels[0].top;
    const across = ticks(view[0] * data.scale, view[1] * data.scale, 8);
    data.panels.forEach((panel, own) => {
      const [low, high] = range(panel, own, from, to);
      const y = (value) => panel.bottom - (value - low) / (high - low) * (panel.bottom - panel.top);
      scales.push(y);
      const final = own === data.panels.length - 1;
      across.forEach((tick) => {
        const at = x(tick.value / data.scale);
        line(drawn, "grid", at, panel.top, at, panel.bottom);
        if (final) {
          line(drawn, "tick", at, panel.bottom, at, panel.bottom + 5);
          element(drawn, "text", { class: "muted", x: at, y: panel.bottom + 20, "text-anchor": "middle" }, tick.text);
        }
      });
      ticks(low, high, (panel.bottom - panel.top) / 40).forEach((tick) => {
        const at = y(tick.value);
        line(drawn, "grid", data.left, at, data.right, at);
        line(drawn, "tick", data.left - 5, at, data.left, at);
        element(drawn, "text", { class: "muted", x: data.left - 9, y: at + 5, "text-anchor": "end" }, tick.text);
      });
      line(drawn, "zero", data.left, y(0), data.right, y(0));
      const inside = element(drawn, "g", { "clip-path": "url".concat("(#live-", own, ")") });
      const clip = element(inside, "clipPath", { id: "live-" + own });
      element(clip, "rect", { x: data.left, y: panel.top, width: data.right - data.left, height: panel.bottom - panel.top });
      if (final) line(inside, "limit", data.left, y(data.limit), data.right, y(data.limit));
      panel.curves.forEach((curve) => {
        if (hidden.has(curve.column)) return;
        element(inside, "path", { class: curve.class, d: path(columns[curve.column], panel.factor, y, from, to) });
      });
      const bar = final ? data.bar : null;
      if (bar) {
        const at = x(bar.at_s);
        line(inside, "mark error-bar", at, y(bar.low), at, y(bar.high));
        [bar.low, bar.high].forEach((end) => line(inside, "mark error-bar", at - 5, y(end), at + 5, y(end)));
      }
      data.marks.forEach((mark) => {
        const seen = inView(mark);
        if (!seen) return;
        const [start, end] = seen.map(x);
        if (end > start) {
          element(drawn, "rect", { class: mark.class, x: start, y: panel.top, width: end - start, height: panel.bottom - panel.top });
        } else {
          line(drawn, mark.class, start, panel.top, start, panel.bottom);
        }
      });
      element(drawn, "rect", { class: "frame", x: data.left, y: panel.top, width: data.right - data.left, height: panel.bottom - panel.top });
      element(drawn, "text", { "text-anchor": "middle", transform: "translate(" + (data.left - 61) + " " + (panel.top + panel.bottom) / 2 + ") rotate(-90)" }, panel.title);
      if (final) {
        const degrees = 180 / Math.PI;
        let letters = 0;
        ticks(low * degrees, high * degrees, (panel.bottom - panel.top) / 50).forEach((tick) => {
          const at = y(tick.value / degrees);
          letters = Math.max(letters, tick.text.length);
          line(drawn, "tick", data.right, at, data.right + 5, at);
          element(drawn, "text", { class: "muted", x: data.right + 9, y: at + 5 }, tick.text);
        });
        element(drawn, "text", { "text-anchor": "middle", transform: "translate(" + (data.right + 25 + 8.5 * letters) + " " + (panel.top + panel.bottom) / 2 + ") rotate(-90)" }, "angle \u03c6 [\u00b0]");
        element(drawn, "text", { x: (data.left + data.right) / 2, y: panel.bottom + 42, "text-anchor": "middle" }, "time [" + data.unit + "]");
      }
    });
    labels(top);
    point();
  }

  // Writes the names of the marks in rows above the panels, none upon another.
  function labels(top) {
    const taken = [];
    data.marks.forEach((mark) => {
      const seen = inView(mark);
      if (!seen) return;
      const place = x(0.5 * (seen[0] + seen[1]));
      const half = mark.text.length * 3.7 + 6;
      const middle = hold(place, half, 900 - half);
      let row = 0;
      const meets = (other) => other[0] === row ? middle + half > other[1] ? other[2] > middle - half : false : false;
      while (taken.some(meets)) row += 1;
      taken.push([row, middle - half, middle + half]);
      const y = top - 6 - 18 * row;
      line(drawn, mark.class, place, y + 1, place, top);
      element(drawn, "text", { class: "muted", x: middle, y: y - 2, "text-anchor": "middle" }, mark.text);
    });
  }

  const live = element(svg, "g", { class: "cursors" });
  function point() {
    live.textContent = "";
    [[cursor, "cursor"], [second, "cursor two"]].forEach(([at, kind]) => {
      if (at === null) return;
      const place = x(time[at]);
      if (data.left - 0.5 > place) return;
      if (place > data.right + 0.5) return;
      data.panels.forEach((panel, own) => {
        line(live, kind, place, panel.top, place, panel.bottom);
        panel.curves.forEach((curve) => {
          const y = scales[own] ? scales[own](columns[curve.column][at] * panel.factor) : -1;
          if (hidden.has(curve.column)) return;
          if (panel.top > y) return;
          if (y > panel.bottom) return;
          element(live, "circle", { class: "dot", cx: place, cy: y, r: 3 });
        });
      });
    });
    if (band) {
      const left = Math.min(band[0], band[1]);
      element(live, "rect", { class: "ribbon of-rigid", x: left, y: data.panels[0].top, width: Math.abs(band[0] - band[1]), height: data.panels[2].bottom - data.panels[0].top });
    }
    readout.textContent = cursor === null ? hint : read();
  }

  const hint = "Point at the plot to read it off; click or press B for a second cursor. Drag to zoom, Shift and drag to move, double click for the event. Keys: \u2190 \u2192 cursor, + \u2212 zoom, , . move, 0 event.";
  function figures(value, digits) {
    const text = Number(value.toPrecision(digits));
    return String(text).replace("-", "\u2212");
  }
  function values(at, base) {
    const parts = [];
    const change = (column, factor) => (columns[column][at] - (base === null ? 0 : columns[column][base])) * factor;
    const sign = base === null ? "" : "\u0394";
    const t = (time[at] - (base === null ? 0 : time[base])) * data.scale;
    parts.push(sign + "t " + figures(t, 6) + " " + data.unit);
    data.panels.forEach((panel, own) => panel.curves.forEach((curve) => {
      if (hidden.has(curve.column)) return;
      const value = change(curve.column, panel.factor);
      const degrees = own === 2 ? " (" + figures(value * 180 / Math.PI, 3) + "\u00b0)" : "";
      const text = sign + ["a ", "v ", "\u03c6 "][own] + figures(value, 4) + [" g ", " m/s ", " rad"][own] + degrees;
      parts.push((text + " " + curve.read).replace(/ +/g, " ").trim());
    }));
    return parts.join(" \u00b7 ");
  }
  function read() {
    const first = values(cursor, null);
    return second === null ? first : first + "\n" + values(cursor, second);
  }

  function show(from, to) {
    const least = 4 * (time[last] - time[0]) / last;
    const length = hold(to - from, least, data.span[1] - data.span[0]);
    const start = hold(from, data.span[0], data.span[1] - length);
    view = [start, start + length];
    draw();
  }
  function zoom(factor, about) {
    show(about - (about - view[0]) * factor, about + (view[1] - about) * factor);
  }
  function move(part) {
    const step = part * (view[1] - view[0]);
    show(view[0] + step, view[1] + step);
  }
  const middle = () => cursor === null ? (view[0] + view[1]) / 2 : time[cursor];
  const event = () => show(data.view[0], data.view[1]);

  function button(text, act, pressed) {
    const made = document.createElement("button");
    made.type = "button";
    made.textContent = text;
    if (pressed !== undefined) made.setAttribute("aria-pressed", String(pressed));
    made.addEventListener("click", () => act(made));
    bar.append(made);
    return made;
  }
  button("Zoom in", () => zoom(0.5, middle()));
  button("Zoom out", () => zoom(2, middle()));
  button("Event", event);
  button("Whole record", () => show(data.span[0], data.span[1]));
  button("Second cursor", () => {
    second = nearest(middle());
    cursor = second;
    point();
  });
  button("Whole angle", (made) => {
    whole = !whole;
    made.textContent = whole ? "Around the limit angle" : "Whole angle";
    draw();
  });
  function toggle(curve) {
    const made = button(curve.name, () => {
      if (!hidden.delete(curve.column)) hidden.add(curve.column);
      made.setAttribute("aria-pressed", String(!hidden.has(curve.column)));
      draw();
    }, true);
    const sample = document.createElementNS(svg.namespaceURI, "svg");
    const size = { class: "plot", viewBox: "0 0 26 4", width: 26, height: 4, "aria-hidden": "true" };
    for (const key in size) sample.setAttribute(key, size[key]);
    element(sample, "line", { class: curve.class, x1: 0, y1: 2, x2: 26, y2: 2 });
    made.prepend(sample);
    return made;
  }
  data.panels.forEach((panel) => panel.curves.forEach(toggle));
  link(from || URL.createObjectURL(new Blob([csv], { type: "text/csv" })));
  const readout = document.createElement("output");
  readout.setAttribute("aria-live", "off");
  bar.append(readout);

  // A page that is served lays one more curve of the angle over the report's, at the same instants; without
  // values it goes.
  const further = { class: "what-if", column: width, name: "what if", read: "what if" };
  let shows = null;
  figure.addEventListener("what-if", (given) => {
    const curves = data.panels[data.panels.length - 1].curves;
    const fits = given.detail ? given.detail.length === time.length : false;
    if (curves.includes(further)) curves.pop();
    if (shows) shows.remove();
    shows = null;
    if (fits) {
      columns[width] = given.detail;
      curves.push(further);
      shows = toggle(further);
      bar.insertBefore(shows, readout);
    }
    draw();
  });

  function place(pointer) {
    const box = svg.getBoundingClientRect();
    return (pointer.clientX - box.left) / box.width * svg.viewBox.baseVal.width;
  }
  const pointers = new Map();
  let begun = null;
  svg.setAttribute("tabindex", "0");
  svg.addEventListener("pointerdown", (pointer) => {
    pointers.set(pointer.pointerId, place(pointer));
    begun = { at: place(pointer), view: view.slice(), shift: pointer.shiftKey, spread: null };
    svg.setPointerCapture(pointer.pointerId);
  });
  svg.addEventListener("pointermove", (pointer) => {
    const at = place(pointer);
    if (pointers.has(pointer.pointerId)) pointers.set(pointer.pointerId, at);
    if (pointers.size === 2) return pinch();
    const dragged = pointers.size === 1 ? pointer.pointerType === "mouse" : false;
    if (dragged) {
      if (begun.shift) {
        const step = (begun.at - at) / (data.right - data.left) * (begun.view[1] - begun.view[0]);
        return show(begun.view[0] + step, begun.view[1] + step);
      }
      band = Math.abs(at - begun.at) > 4 ? [begun.at, at] : null;
    }
    cursor = nearest(hold(instant(at), view[0], view[1]));
    point();
  });
  function pinch() {
    const [one, other] = Array.from(pointers.values());
    const spread = Math.max(Math.abs(one - other), 10);
    const about = instant((one + other) / 2);
    if (begun.spread) zoom(begun.spread / spread, about);
    begun.spread = spread;
  }
  function end(pointer) {
    pointers.delete(pointer.pointerId);
    if (band) {
      const [one, other] = band.map(instant);
      band = null;
      show(Math.min(one, other), Math.max(one, other));
    } else if (begun) {
      const still = Math.abs(place(pointer) - begun.at) > 4 ? false : pointer.type === "pointerup";
      cursor = nearest(hold(instant(place(pointer)), view[0], view[1]));
      if (still) second = pointer.pointerType === "mouse" ? cursor : second;
      point();
    }
    begun = pointers.size > 0 ? begun : null;
  }
  svg.addEventListener("pointerup", end);
  svg.addEventListener("pointercancel", end);
  svg.addEventListener("dblclick", () => {
    second = null;
    event();
  });
  svg.addEventListener("wheel", (wheel) => {
    if (!wheel.ctrlKey) return;
    wheel.preventDefault();
    zoom(wheel.deltaY > 0 ? 1.25 : 0.8, instant(place(wheel)));
  }, { passive: false });
  svg.addEventListener("keydown", (key) => {
    const step = key.shiftKey ? 10 : 1;
    const at = cursor === null ? nearest(middle()) : cursor;
    const acts = {
      ArrowLeft: () => { cursor = Math.max(at - step, 0); },
      ArrowRight: () => { cursor = Math.min(at + step, last); },
      "+": () => zoom(0.5, middle()),
      "=": () => zoom(0.5, middle()),
      "-": () => zoom(2, middle()),
      ",": () => move(-0.25),
      ".": () => move(0.25),
      0: event,
      b: () => { second = at; cursor = at; },
      B: () => { second = at; cursor = at; },
      Escape: () => { second = null; cursor = null; },
    };
    const act = acts[key.key];
    if (!act) return;
    key.preventDefault();
    act();
    if (cursor !== null) {
      if (view[0] > time[cursor]) move(-0.25);
      if (time[cursor] > view[1]) move(0.25);
    }
    point();
  });

  // The address keeps what is seen and both cursors, so that it can be handed on.
  function keep() {
    const seen = new URLSearchParams();
    seen.set("t", view.map((at) => Number(at.toFixed(7))).join(".."));
    if (second !== null) seen.set("a", Number(time[second].toFixed(7)));
    if (cursor !== null) seen.set("b", Number(time[cursor].toFixed(7)));
    history.replaceState(null, "", "#" + seen);
  }
  function recall() {
    const seen = new URLSearchParams(location.hash.slice(1));
    const at = (name) => seen.has(name) ? nearest(Number(seen.get(name))) : null;
    const [start, end] = (seen.get("t") || "").split("..").map(Number);
    second = at("a");
    cursor = seen.has("b") ? at("b") : second;
    if (end > start) show(start, end); else draw();
  }
  ["click", "dblclick", "pointerup", "keyup"].forEach((kind) => figure.addEventListener(kind, keep));
  recall();
})();
