// The compiler in its worker. One request runs at a time. A request that takes too long ends the worker: models come from
// strangers too.

const LONGEST = 20000;

export class Compiler {
  /** @param {Pick<import("./connection.js").Parts, "worker"|"compiler">} parts */
  constructor(parts) {
    this.parts = parts;
    /** @type {Worker|null} */
    this.worker = null;
    this.last = Promise.resolve();
  }

  // asks the compiler; the answer has `ok`, and `text` where it is a refusal
  /**
   * @param {object} request
   * @param {Uint8Array} [bytes]
   * @returns {Promise<any>}
   */
  ask(request, bytes) {
    const answer = this.last.then(() => this.run(request, bytes));
    this.last = answer.catch(() => undefined);
    return answer;
  }

  async run(request, bytes = new Uint8Array()) {
    if (!this.worker) {
      const wasm = await this.parts.compiler();
      this.worker = this.parts.worker();
      this.worker.postMessage({ wasm });
    }
    const worker = this.worker;
    return new Promise(done => {
      const timer = setTimeout(() => end(`the compiler took longer than ${LONGEST / 1000} s; make the model smaller`), LONGEST);
      const end = text => {
        clearTimeout(timer);
        worker.terminate();
        this.worker = null;
        done({ ok: false, text });
      };
      worker.onerror = event => { event.preventDefault(); end(`the compiler stopped: ${event.message || "it cannot be loaded"}`); };
      worker.onmessage = ({ data }) => {
        clearTimeout(timer);
        done({ ...data.object, bytes: data.bytes });
      };
      worker.postMessage({ request, bytes });
    });
  }
}
