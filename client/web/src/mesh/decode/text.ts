/** Numbers and lines out of text files of many megabytes, without a string for each. */

const SPACE = 32, TAB = 9, RETURN = 13, NEWLINE = 10, HASH = 35, MINUS = 45, PLUS = 43, POINT = 46, ZERO = 48, NINE = 57;
const POWERS = Array.from({ length: 23 }, (_, n) => 10 ** n);

export class Scanner {
  at = 0;
  line = 1;
  constructor(readonly bytes: Uint8Array) {}

  get done(): boolean { return this.at >= this.bytes.length; }

  skipBlanks(): void {
    const { bytes } = this;
    while (this.at < bytes.length && (bytes[this.at] === SPACE || bytes[this.at] === TAB || bytes[this.at] === RETURN)) this.at++;
  }

  /** Whether nothing but a comment is left on this line. */
  get lineDone(): boolean {
    this.skipBlanks();
    return this.done || this.bytes[this.at] === NEWLINE || this.bytes[this.at] === HASH;
  }

  nextLine(): void {
    const end = this.bytes.indexOf(NEWLINE, this.at);
    this.at = end < 0 ? this.bytes.length : end + 1;
    this.line++;
  }

  /** Over blanks, comments and line ends, to the next thing. */
  skipToWord(): void {
    while (!this.done && this.lineDone) this.nextLine();
  }

  word(): string {
    this.skipBlanks();
    const start = this.at;
    const { bytes } = this;
    while (this.at < bytes.length && bytes[this.at] > SPACE) this.at++;
    return new TextDecoder('latin1').decode(bytes.subarray(start, this.at));
  }

  number(): number {
    this.skipBlanks();
    const { bytes } = this;
    const start = this.at;
    let at = start, sign = 1, mantissa = 0, digits = 0, scale = 0;
    if (bytes[at] === MINUS || bytes[at] === PLUS) sign = bytes[at++] === MINUS ? -1 : 1;
    for (; bytes[at] >= ZERO && bytes[at] <= NINE; at++, digits++) mantissa = mantissa * 10 + bytes[at] - ZERO;
    if (bytes[at] === POINT) {
      for (at++; bytes[at] >= ZERO && bytes[at] <= NINE; at++, digits++, scale++) mantissa = mantissa * 10 + bytes[at] - ZERO;
    }
    // Exponents, long numbers and words such as "nan" are rare enough for the slow way.
    const plain = digits > 0 && digits < 16 && !(bytes[at] > SPACE && bytes[at] !== 47);
    if (!plain) {
      const text = this.word();
      const value = Number(text);
      if (text === '' || Number.isNaN(value)) throw new Error(`not a number but "${text.slice(0, 40)}" (line ${this.line})`);
      return value;
    }
    this.at = at;
    return (sign * mantissa) / POWERS[scale];
  }
}

/** Arrays that grow. */
export class Growing<T extends Float64Array | Uint32Array | Uint8Array> {
  size = 0;
  constructor(private array: T) {}

  push(value: number): void {
    if (this.size === this.array.length) {
      const larger = new (this.array.constructor as new (size: number) => T)(this.array.length * 2);
      larger.set(this.array);
      this.array = larger;
    }
    this.array[this.size++] = value;
  }

  take(): T { return this.array.slice(0, this.size) as T; }
}

export const numbers = () => new Growing(new Float64Array(1 << 16));
export const indexes = () => new Growing(new Uint32Array(1 << 16));

/** Adds a polygon as a fan; refuses corners that do not exist. */
export function addPolygon(to: Growing<Uint32Array>, corners: ArrayLike<number>, count: number, vertices: number, where: string): void {
  for (let k = 0; k < count; k++) {
    if (!(corners[k] >= 0 && corners[k] < vertices)) throw new Error(`a face uses vertex ${corners[k]} of ${vertices} (${where})`);
  }
  for (let k = 2; k < count; k++) {
    to.push(corners[0]);
    to.push(corners[k - 1]);
    to.push(corners[k]);
  }
}
