// <ca-instrument src="model.ca.toml">: an instrument in any page. The model may also stand inside the element, as text.
// Each instrument is a separate page in a frame, so several do not disturb each other. One that is out of sight is
// suspended.

import { pack } from "./index.js";

const PAGE = new URL("page/play.html", import.meta.url);

class Instrument extends HTMLElement {
  static observedAttributes = ["src"];

  connectedCallback() {
    if (this.frame) return;
    if (!this.style.display) this.style.display = "block";
    if (!this.style.height && !this.clientHeight) this.style.height = "480px";
    this.frame = document.createElement("iframe");
    this.frame.title = this.getAttribute("title") || "An instrument";
    this.frame.allow = "autoplay; midi; gamepad; clipboard-write";
    this.frame.style.cssText = "width: 100%; height: 100%; border: 0";
    this.written = this.textContent;
    this.replaceChildren(this.frame);
    this.watch = new IntersectionObserver(entries => {
      const seen = entries[entries.length - 1].isIntersecting;
      this.frame.contentWindow?.postMessage({ ca: seen ? "resume" : "suspend" }, PAGE.origin);
    });
    this.watch.observe(this);
    this.show();
  }

  disconnectedCallback() {
    this.watch?.disconnect();
    this.replaceChildren();
    this.frame = null;
  }

  attributeChangedCallback() {
    if (this.frame) this.show();
  }

  async show() {
    const src = this.getAttribute("src");
    let text = this.written;
    if (src) {
      const found = await fetch(src);
      if (!found.ok) throw new Error(`${src}: ${found.status}`);
      text = await found.text();
    }
    const at = new URL(PAGE);
    at.hash = "model=" + await pack(text);
    this.frame.src = String(at);
  }
}

customElements.define("ca-instrument", Instrument);

export { Instrument };
