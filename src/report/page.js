"use strict";
(() => {
  // Figures: the nearest point speaks on hover; one stop of the tab key for each figure, arrows from point to point.
  const tip = document.getElementById("tip");
  const show = (svg, point) => {
    svg.querySelectorAll(".near").forEach((other) => other.classList.remove("near"));
    if (!point) { tip.hidden = true; return; }
    point.classList.add("near");
    tip.textContent = point.getAttribute("aria-label");
    tip.hidden = false;
    const at = point.getBoundingClientRect(), room = document.documentElement.clientWidth;
    tip.style.left = Math.max(4, Math.min(at.right + 10, room - tip.offsetWidth - 4)) + scrollX + "px";
    const above = at.top - tip.offsetHeight - 8;
    tip.style.top = (above > 0 ? above : at.bottom + 8) + scrollY + "px";
  };
  for (const svg of document.querySelectorAll("svg.figure")) {
    const points = [...svg.querySelectorAll(".point")];
    if (points.length === 0) continue;
    const places = points.map((point) => [+point.dataset.x, +point.dataset.y]);
    const go = (index) => {
      points.forEach((point) => point.setAttribute("tabindex", "-1"));
      points[index].setAttribute("tabindex", "0");
      points[index].focus();
    };
    points.forEach((point, index) => {
      point.setAttribute("tabindex", index === 0 ? "0" : "-1");
      point.addEventListener("focus", () => show(svg, point));
      point.addEventListener("blur", () => show(svg, null));
      point.addEventListener("keydown", (event) => {
        const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
        if (event.key === "Escape") show(svg, null);
        if (!step) return;
        event.preventDefault();
        go((index + step + points.length) % points.length);
      });
    });
    svg.addEventListener("pointermove", (event) => {
      const scale = svg.viewBox.baseVal.width / svg.clientWidth, box = svg.getBoundingClientRect();
      const x = (event.clientX - box.left) * scale, y = (event.clientY - box.top) * scale;
      let best = null, least = 28;
      places.forEach(([px, py], index) => {
        const distance = Math.hypot(px - x, py - y);
        if (distance < least) { least = distance; best = points[index]; }
      });
      show(svg, best);
    });
    svg.addEventListener("pointerleave", () => show(svg, null));
  }

  // The chooser.
  const source = document.getElementById("choices");
  if (!source) return;
  const choices = JSON.parse(source.textContent), byId = (id) => document.getElementById(id);
  const resistances = [...new Set(choices.map((choice) => choice.r_ohm))].sort((a, b) => a - b);
  const ohms = (value) => value >= 1e6 ? +(value / 1e6).toPrecision(3) + " Mohm" : value >= 1e3 ? +(value / 1e3).toPrecision(3) + " kohm" : +value.toPrecision(3) + " ohm";
  const seconds = (value) => value >= 1 ? +value.toPrecision(3) + " s" : +(1e3 * value).toPrecision(3) + " ms";
  // Null where nothing is typed. The first half of what was meant is no answer: "2 kohm" is not 2.
  const number = (text) => text.trim() ? Number(text.trim().replace(",", ".")) : null;
  byId("want-r").append(...resistances.map((r) => new Option(ohms(r), r, false, r === 1000)));
  // How the answer is measured again; other capacitors than the scene's, and a configuration, are no option of a command.
  const again = (choice) => choice.size || !("again" in source.dataset) ? [] : [" Measured again, with the --scene of this report: ", { code: `cermctl characterize --circuit ${choice.kind.split("-")[0]} ` +
    `--method ${choice.method} --r "${choice.r_ohm} ohm" --average "${choice.average_s ? seconds(choice.average_s) : "0 s"}" --out again` }];
  const settings = (choice) => `method = "${choice.method}"` + (choice.average_s ? `, average = "${seconds(choice.average_s)}"` : "");
  const say = (parts) => {
    byId("chosen").replaceChildren(...parts.map((part) => {
      const element = document.createElement(part.code ? "code" : "span");
      element.textContent = part.code || part;
      return element;
    }));
  };
  const choose = () => {
    const r = +byId("want-r").value, error = number(byId("want-error").value), rate = number(byId("want-rate").value);
    if (error !== null && !(error > 0)) return say(["As an error a number of ohm is wanted, such as 2.5."]);
    if (rate !== null && !(rate > 0)) return say(["As a rate a number of readings a second is wanted, such as 50."]);
    if (!error && !rate) return say(["Type an error or a rate."]);
    const here = choices.filter((choice) => choice.r_ohm === r);
    const fits = here.filter((choice) => (!error || choice.error_ohm <= error) && (!rate || 1 / choice.seconds >= rate));
    if (fits.length === 0) {
      const finest = here.reduce((a, b) => a.error_ohm < b.error_ohm ? a : b), fastest = here.reduce((a, b) => a.seconds < b.seconds ? a : b);
      return say([`Nothing that was measured at ${ohms(r)} does. The smallest error is ${ohms(finest.error_ohm)}, one in ${seconds(finest.seconds)}; ` +
        `the fastest readings come every ${seconds(fastest.seconds)}, with ${ohms(fastest.error_ohm)}.`]);
    }
    // What was not asked for is what is left to be had.
    const best = fits.reduce((a, b) => (error && !rate ? a.seconds <= b.seconds : a.error_ohm <= b.error_ohm) ? a : b);
    const u = best.u_ohm ? `, stated ${ohms(best.u_ohm)}` : "";
    const lost = best.lost ? `, ${+(100 * best.lost).toPrecision(2)} % of all readings lost` : "";
    say([`${best.name}: error ${ohms(best.error_ohm)}${u}, one reading in ${seconds(best.seconds)}, ${+(1 / best.seconds).toPrecision(3)} a second${lost}. In [circuit]: `,
      { code: `kind = "${best.kind}"` }, ", in [measure]: ", { code: settings(best) }, ".", ...again(best)]);
  };
  byId("chooser").addEventListener("input", choose);
  byId("chooser").addEventListener("submit", (event) => event.preventDefault());
  choose();
})();
