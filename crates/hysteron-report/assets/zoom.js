// Zoom for the figures of a report: drag selects, double-click or Escape resets, the pointer reads values.
// The drawing that came with the page is kept and put back on reset; without this script it stands as it is.
(() => {
  "use strict";
  const NS = "http://www.w3.org/2000/svg", LAST = 0xffffff;
  const make = (tag, attributes, parent) => {
    const node = document.createElementNS(NS, tag);
    for (const key in attributes) node.setAttribute(key, attributes[key]);
    if (parent) parent.appendChild(node);
    return node;
  };
  const round = (v) => Math.round(v * 100) / 100;
  const power = (m, e) => (e < 0 ? m / 10 ** -e : m * 10 ** e);
  const raised = (n) => String(n).replace(/./g, (c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c]));

  // The tick rules of figure/ticks.rs: steps of 1, 2, 5; decades on logarithmic axes.
  const fixed = (value, decimals) => {
    const text = Math.abs(value).toFixed(decimals);
    let [whole, rest] = text.split(".");
    if (whole.length > 4) whole = whole.replace(/\B(?=(\d{3})+$)/g, "\u2009");
    return (value < 0 && /[1-9]/.test(text) ? "−" : "") + whole + (rest ? "." + rest : "");
  };
  const stepAtLeast = (raw) => {
    const d = Math.floor(Math.log10(raw));
    for (const [m, e] of [[1, d], [2, d], [5, d], [1, d + 1]]) if (power(m, e) >= raw * (1 - 1e-12)) return [m, e];
    return [2, d + 1];
  };
  const linearTicks = (low, high, limit, exponent) => {
    let [m, e] = stepAtLeast((0.4 * (high - low)) / limit), first, last;
    for (;;) {
      const size = power(m, e);
      [first, last] = [Math.ceil(low / size - 1e-9), Math.floor(high / size + 1e-9)];
      if (!(last - first + 1 > limit)) break;
      [m, e] = stepAtLeast(1.01 * size);
    }
    const decimals = Math.min(12, Math.max(0, exponent - e)), major = [];
    for (let i = first; i <= last; i++) {
      const v = power(i * m, e);
      major.push([v, fixed(v / 10 ** exponent, decimals)]);
    }
    return { major, minor: [] };
  };
  const logTicks = (t0, t1, limit) => {
    const d0 = Math.floor(t0 - 1e-9), d1 = Math.ceil(t1 + 1e-9);
    const pick = (ms) => {
      const out = [];
      for (let d = d0; d <= d1; d++) for (const m of ms) {
        const v = power(m, d), t = Math.log10(v);
        if (t >= t0 - 1e-9 && t <= t1 + 1e-9) out.push(v);
      }
      return out;
    };
    const fine = pick([1, 2, 5]);
    if (fine.length < 3) return linearTicks(10 ** t0, 10 ** t1, limit, 0);
    const decades = pick([1]);
    let major = fine;
    if (fine.length > limit || decades.length >= 4) {
      const every = Math.max(1, Math.ceil(decades.length / limit));
      major = decades.filter((v) => Math.round(Math.log10(v)) % every === 0);
      if (major.length < 2) major = fine.slice(0, limit);
    }
    const plain = 10 ** t0 >= 0.99e-3 && 10 ** t1 <= 1.01e5;
    const label = (v) => {
      const e = Math.floor(Math.log10(v) + 1e-9);
      if (plain) return fixed(v, Math.max(0, -e));
      const m = Math.round(v / 10 ** e);
      return (m === 1 ? "" : m + "×") + "10" + raised(e);
    };
    const minor = decades.length <= 10 ? pick([1, 2, 3, 4, 5, 6, 7, 8, 9]) : decades;
    return { major: major.map((v) => [v, label(v)]), minor: minor.filter((v) => !major.includes(v)) };
  };

  // Curve data: 24 bits a coordinate over -1 … 2 of the axis, base 64; all ones is a break.
  const decode = (text) => {
    const raw = atob(text), points = [];
    for (let i = 0; i + 5 < raw.length; i += 6) {
      const at = (j) => (raw.charCodeAt(i + j) << 16) | (raw.charCodeAt(i + j + 1) << 8) | raw.charCodeAt(i + j + 2);
      const a = at(0), b = at(3);
      points.push(a === LAST ? null : [(a / (LAST - 1)) * 3 - 1, (b / (LAST - 1)) * 3 - 1]);
    }
    return points;
  };

  class Axis {
    constructor(text) {
      const [scale, low, high, exponent, limit, shown] = text.split(" ");
      Object.assign(this, { log: scale === "log", home: [+low, +high], exponent: +exponent, limit: +limit, shown: shown === "1" });
      this.now = this.home.slice();
    }
    fraction(t) { return (t - this.now[0]) / (this.now[1] - this.now[0]); }
    fromHome(f) { return this.fraction(this.home[0] + f * (this.home[1] - this.home[0])); }
    at(f) { return this.now[0] + f * (this.now[1] - this.now[0]); }
    transform(v) { return this.log ? Math.log10(v) : v; }
    zoom(f0, f1) {
      const next = [this.at(f0), this.at(f1)];
      if (next[1] - next[0] > 2e-5 * (this.home[1] - this.home[0])) this.now = next;
    }
    ticks() {
      return this.log ? logTicks(this.now[0], this.now[1], this.limit)
        : linearTicks(this.now[0], this.now[1], this.limit, this.exponent);
    }
    read(f) {
      const t = this.at(f), v = (this.log ? 10 ** t : t) / 10 ** this.exponent;
      const span = this.log ? Math.abs(v) * 0.05 : (this.now[1] - this.now[0]) / 10 ** this.exponent;
      return fixed(v, Math.min(9, Math.max(0, 3 - Math.ceil(Math.log10(span)))));
    }
    get zoomed() { return this.now[0] !== this.home[0] || this.now[1] !== this.home[1]; }
  }

  class Panel {
    // A drawing for narrow screens has no data of its own: `twin` is the same panel of the wide one.
    constructor(group, twin) {
      this.group = group;
      const stored = twin ? [...twin.querySelectorAll("[data-points]")] : [];
      stored.forEach((node, i) => { group.querySelectorAll(".line,.band,.mark")[i].source = node; });
      const [x, y, w, h] = group.dataset.frame.split(" ").map(Number);
      Object.assign(this, { x, y, w, h, ax: new Axis(group.dataset.x), ay: new Axis(group.dataset.y) });
      this.parts = [...group.querySelectorAll(".grid,.minor,.marks,.line,.band,.mark")].map((node) => [node, node.getAttribute("d")]);
      this.labels = [".tx", ".ty"].map((name) => group.querySelector(name));
      this.firstLabels = this.labels.map((node) => [...node.childNodes]);
      this.spans = [...group.querySelectorAll("[data-span]")].map((node) => {
        const rect = node.querySelector("rect");
        return { rect, range: node.dataset.span.split(" ").map(Number), first: [rect.getAttribute("x"), rect.getAttribute("width")] };
      });
      this.catch = make("rect", { class: "catch", x, y, width: w, height: h, tabindex: "0" }, group);
      this.pick = make("rect", { class: "pick", visibility: "hidden" }, group);
    }
    get zoomed() { return this.ax.zoomed || this.ay.zoomed; }
    // Fits the y axis to what the x axis shows.
    fitY() {
      let low = Infinity, high = -Infinity;
      for (const [node] of this.parts) {
        for (const p of this.points(node)) {
          if (!p) continue;
          const f = this.ax.fromHome(p[0]);
          if (f >= 0 && f <= 1) { low = Math.min(low, p[1]); high = Math.max(high, p[1]); }
        }
      }
      if (!(high >= low)) return;
      const margin = Math.max(0.06 * (high - low), 1e-4), home = this.ay.home, span = home[1] - home[0];
      this.ay.now = this.ax.zoomed ? [home[0] + (low - margin) * span, home[0] + (high + margin) * span] : home.slice();
    }
    px(f) { return this.x + f * this.w; }
    py(f) { return this.y + this.h - f * this.h; }
    points(node) {
      const source = node.source || node;
      if (!source.points) source.points = decode(source.dataset.points || "");
      return source.points;
    }
    draw() {
      if (!this.zoomed) return this.restore();
      this.drawAxes();
      for (const [node] of this.parts) {
        if (!(node.source || node).dataset.points) continue;
        const shape = node.dataset.mark, closed = node.classList.contains("band");
        let d = "", pen = false, before = null;
        for (const p of this.points(node)) {
          if (!p) { pen = false; before = null; continue; }
          const fx = this.ax.fromHome(p[0]), fy = this.ay.fromHome(p[1]);
          const here = [this.px(Math.min(60, Math.max(-60, fx))), this.py(Math.min(60, Math.max(-60, fy)))];
          const inside = fx >= -0.02 && fx <= 1.02 && fy >= -0.02 && fy <= 1.02;
          if (shape) { if (inside) d += "M" + round(here[0]) + " " + round(here[1]) + shape; continue; }
          // A step whose two ends lie beyond the same side of the frame cannot be seen.
          const hidden = !closed && before && ((before.fx < 0 && fx < 0) || (before.fx > 1 && fx > 1) || (before.fy < 0 && fy < 0) || (before.fy > 1 && fy > 1));
          if (hidden) pen = false;
          else {
            if (!pen && before) d += "M" + round(before.here[0]) + " " + round(before.here[1]);
            if (before) d += "L" + round(here[0]) + " " + round(here[1]);
            else if (closed) d += "M" + round(here[0]) + " " + round(here[1]);
            pen = before !== null || closed;
          }
          before = { here, fx, fy };
        }
        node.setAttribute("d", closed && d ? d + "z" : d);
      }
      for (const s of this.spans) {
        const [a, b] = s.range.map((t) => Math.min(1, Math.max(0, this.ax.fraction(t))));
        s.rect.setAttribute("x", round(this.px(a)));
        s.rect.setAttribute("width", round((b - a) * this.w));
      }
    }
    drawAxes() {
      const tx = this.ax.ticks(), ty = this.ay.ticks(), bottom = this.y + this.h, right = this.x + this.w;
      const X = (v) => round(this.px(this.ax.fraction(this.ax.transform(v))));
      const Y = (v) => round(this.py(this.ay.fraction(this.ay.transform(v))));
      const set = (name, d) => this.group.querySelector(name).setAttribute("d", d);
      const lines = (xs, ys) => xs.map((v) => `M${X(v)} ${this.y}V${bottom}`).join("") + ys.map((v) => `M${this.x} ${Y(v)}H${right}`).join("");
      const mx = tx.major.map((t) => t[0]), my = ty.major.map((t) => t[0]);
      set(".grid", lines(mx, my));
      set(".minor", lines(tx.minor, ty.minor));
      set(".marks", mx.map((v) => `M${X(v)} ${bottom}v5`).join("") + tx.minor.map((v) => `M${X(v)} ${bottom}v3`).join("")
        + my.map((v) => `M${this.x} ${Y(v)}h-5`).join("") + ty.minor.map((v) => `M${this.x} ${Y(v)}h-3`).join(""));
      const [gx, gy] = this.labels;
      gx.replaceChildren();
      gy.replaceChildren();
      let free = -Infinity;
      if (this.ax.shown) for (const [v, label] of tx.major) {
        const half = label.length * 3.6;
        if (X(v) - half < free) continue;
        make("text", { x: X(v), y: bottom + 18 }, gx).textContent = label;
        free = X(v) + half + 4;
      }
      for (const [v, label] of ty.major) make("text", { x: this.x - 8, y: Y(v) + 4.2 }, gy).textContent = label;
    }
    restore() {
      for (const [node, d] of this.parts) node.setAttribute("d", d);
      this.labels.forEach((node, i) => node.replaceChildren(...this.firstLabels[i]));
      for (const s of this.spans) {
        s.rect.setAttribute("x", s.first[0]);
        s.rect.setAttribute("width", s.first[1]);
      }
    }
  }

  for (const svg of document.querySelectorAll("svg.figure")) {
    const narrow = svg.classList.contains("narrow");
    const twins = narrow ? [...svg.parentNode.querySelectorAll("svg.figure:not(.narrow) .panel[data-frame]")] : [];
    const panels = [...svg.querySelectorAll(".panel[data-frame]")].map((group, i) => new Panel(group, twins[i]));
    const linked = svg.dataset.link === "x";
    const { width, height } = svg.viewBox.baseVal, y = narrow ? height - 1 : 16;
    const readout = make("text", { class: "readout", x: width - 20, y, "text-anchor": "end" }, svg);
    const reset = make("text", { class: "reset", x: width - 20, y, "text-anchor": "end", visibility: "hidden" }, svg);
    reset.textContent = "reset zoom";
    const place = () => {
      const taken = readout.textContent ? readout.getComputedTextLength() + 14 : 0;
      reset.setAttribute("x", width - 20 - taken);
      reset.setAttribute("visibility", panels.some((panel) => panel.zoomed) ? "visible" : "hidden");
    };
    // Brings a new range of one panel to those that share its x axis; y axes that were not chosen are fitted.
    const share = (panel, chosen) => {
      for (const other of linked ? panels : [panel]) {
        other.ax.now = panel.ax.now.slice();
        if (other !== panel || !chosen) other.fitY();
        other.draw();
      }
      place();
    };
    const home = (panel) => {
      for (const other of linked ? panels : [panel]) {
        other.ax.now = other.ax.home.slice();
        other.ay.now = other.ay.home.slice();
        other.draw();
      }
      place();
    };
    for (const panel of panels) {
      const where = (event) => {
        const p = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
        return [Math.min(1, Math.max(0, (p.x - panel.x) / panel.w)), Math.min(1, Math.max(0, (panel.y + panel.h - p.y) / panel.h))];
      };
      let start = null;
      // A drag that is flat selects along x alone, one that is narrow along y alone.
      const selection = (a, b) => {
        const dx = Math.abs(a[0] - b[0]) * panel.w, dy = Math.abs(a[1] - b[1]) * panel.h;
        const order = (i, whole) => (whole ? [0, 1] : [Math.min(a[i], b[i]), Math.max(a[i], b[i])]);
        if (Math.max(dx, dy) < 6) return null;
        return { x: order(0, dx < 6 || dx * 8 < dy), y: order(1, dy < 14 || dy * 8 < dx) };
      };
      panel.catch.addEventListener("pointerdown", (event) => {
        if (event.pointerType === "touch" || event.button !== 0) return;
        start = where(event);
        panel.catch.setPointerCapture(event.pointerId);
      });
      panel.catch.addEventListener("pointermove", (event) => {
        const at = where(event);
        readout.textContent = panel.ax.read(at[0]) + ",  " + panel.ay.read(at[1]);
        place();
        const s = start && selection(start, at);
        panel.pick.setAttribute("visibility", s ? "visible" : "hidden");
        if (s) {
          const box = { x: panel.px(s.x[0]), y: panel.py(s.y[1]), width: (s.x[1] - s.x[0]) * panel.w, height: (s.y[1] - s.y[0]) * panel.h };
          for (const key in box) panel.pick.setAttribute(key, round(box[key]));
        }
      });
      panel.catch.addEventListener("pointerup", (event) => {
        const s = start && selection(start, where(event));
        start = null;
        panel.pick.setAttribute("visibility", "hidden");
        if (!s) return;
        const chosen = s.y[0] > 0 || s.y[1] < 1;
        panel.ax.zoom(...s.x);
        if (chosen) panel.ay.zoom(...s.y);
        share(panel, chosen);
      });
      panel.catch.addEventListener("pointercancel", () => { start = null; panel.pick.setAttribute("visibility", "hidden"); });
      panel.catch.addEventListener("pointerleave", () => { if (!start) { readout.textContent = ""; place(); } });
      panel.catch.addEventListener("dblclick", () => home(panel));
      panel.catch.addEventListener("keydown", (event) => { if (event.key === "Escape") home(panel); });
      // Keyboard: + and - about the middle, arrows to move.
      panel.catch.addEventListener("keydown", (event) => {
        const moves = { "+": [0.15, 0.85, 0.15, 0.85], "-": [-0.2, 1.2, -0.2, 1.2], ArrowLeft: [-0.2, 0.8, 0, 1], ArrowRight: [0.2, 1.2, 0, 1], ArrowUp: [0, 1, 0.2, 1.2], ArrowDown: [0, 1, -0.2, 0.8] };
        const m = moves[event.key];
        if (!m) return;
        event.preventDefault();
        panel.ax.zoom(m[0], m[1]);
        panel.ay.zoom(m[2], m[3]);
        share(panel, true);
      });
    }
    reset.addEventListener("click", () => panels.forEach(home));
  }
  const first = document.querySelector("svg.figure .catch");
  if (first) {
    const hint = document.createElement("p");
    hint.className = "tablenote hint";
    hint.textContent = "Drag in a figure to zoom, double-click to reset.";
    first.closest("figure").appendChild(hint);
  }
  addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((d) => { d.dataset.was = d.open; d.open = true; }));
  addEventListener("afterprint", () => document.querySelectorAll("details").forEach((d) => { d.open = d.dataset.was === "true"; }));
})();
