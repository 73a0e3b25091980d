// A WebAssembly module in its worker: the compiler, or the module that measures. One request runs at a time. A request of
// the compiler that takes too long ends the worker: models come from strangers too.

const LONGEST = 20000;

export class Compiler {
  /**
   * @param {Pick<import("./connection.js").Parts, "worker"|"compiler">} parts
   * @param {number} longest limit for a request [ms]; none if 0
   * @param {(done: number, of: number) => void} progress receives the finished steps of a measurement
   */
  constructor(parts, longest = LONGEST, progress = () => undefined) {
    this.parts = parts;
    this.longest = longest;
    this.progress = progress;
    /** @type {Worker|null} */
    this.worker = null;
    this.last = Promise.resolve();
    /** @type {string|null} reason for which no request runs any more */
    this.ended = null;
    /** @type {((text: string) => void)|null} ends the worker, and refuses its request */
    this.refuse = null;
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

  // ends the worker for good; its requests are refused with this text
  /** @param {string} text */
  end(text) {
    this.ended = text;
    if (this.refuse) this.refuse(text);
  }

  async run(request, bytes = new Uint8Array()) {
    if (!this.worker) {
      const wasm = await this.parts.compiler();
      if (this.ended !== null) return { ok: false, text: this.ended };
      this.worker = this.parts.worker();
      this.worker.postMessage({ wasm });
    }
    const worker = this.worker;
    return new Promise(done => {
      const late = () => this.refuse(`the compiler took longer than ${this.longest / 1000} s; make the model smaller`);
      const timer = this.longest ? setTimeout(late, this.longest) : undefined;
      this.refuse = text => {
        clearTimeout(timer);
        worker.terminate();
        this.worker = null;
        done({ ok: false, text });
      };
      worker.onerror = event => { event.preventDefault(); this.refuse(`the worker stopped: ${event.message || "it cannot be loaded"}`); };
      worker.onmessage = ({ data }) => {
        if (data.progress) return this.progress(data.progress.done, data.progress.of);
        clearTimeout(timer);
        done({ ...data.object, bytes: data.bytes });
      };
      worker.postMessage({ request, bytes });
    });
  }
}
