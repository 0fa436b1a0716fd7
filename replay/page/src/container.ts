// Reads the bytes of one reach; replay/src/container.rs describes and writes them.

/** Data that cannot be shown, with a sentence for the reader of the page. */
export class DataError extends Error {}

const MAGIC = "ubreplay";
const VERSION = 2;
const HEAD_BYTES = 24;

const ARRAYS = {
  u8: Uint8Array,
  u16: Uint16Array,
  i16: Int16Array,
  u32: Uint32Array,
  f32: Float32Array,
  f64: Float64Array,
} as const;

export type NumberType = keyof typeof ARRAYS;
export type ArrayOf<T extends NumberType> = InstanceType<(typeof ARRAYS)[T]>;
export type Numbers = ArrayOf<NumberType>;

/** What a reach is read from: a description, and arrays by their names. */
export interface ReachData {
  readonly reach: unknown;
  array<T extends NumberType>(name: string, type: T): ArrayOf<T>;
}

interface Section {
  name: string;
  type: string;
  offset: number;
  count: number;
}

const CRC_TABLE = Uint32Array.from({ length: 256 }, (_, byte) => {
  let value = byte;
  for (let bit = 0; bit < 8; bit++) value = value & 1 ? (value >>> 1) ^ 0xedb88320 : value >>> 1;
  return value;
});

function crc32(bytes: Uint8Array): number {
  let value = 0xffffffff;
  for (let index = 0; index < bytes.length; index++) value = CRC_TABLE[(value ^ bytes[index]!) & 0xff]! ^ (value >>> 8);
  return (value ^ 0xffffffff) >>> 0;
}

/** The header and the arrays of one reach. */
export class Container implements ReachData {
  readonly reach: unknown;
  readonly #buffer: ArrayBuffer;
  readonly #start: number;
  readonly #sections = new Map<string, Section>();

  /** Throws a DataError unless the bytes are whole and of this version. */
  constructor(buffer: ArrayBuffer) {
    const bytes = new Uint8Array(buffer);
    const foreign = bytes.length < MAGIC.length || [...MAGIC].some((letter, at) => bytes[at] !== letter.charCodeAt(0));
    if (foreign) {
      throw new DataError("These are not the data of a reach. Write the file again with “underbrush replay --out”.");
    }
    const view = new DataView(buffer);
    const short = bytes.length < HEAD_BYTES;
    if (!short && view.getUint32(8, true) !== VERSION) {
      const found = view.getUint32(8, true);
      throw new DataError(`The data have version ${found} of the format; this page reads version ${VERSION}.`);
    }
    const expected = short ? HEAD_BYTES : view.getUint32(16, true);
    if (bytes.length < expected) {
      const found = `${bytes.length.toLocaleString("en")} of ${expected.toLocaleString("en")} bytes`;
      throw new DataError(`The data of this reach are cut off: ${found} are here. Copy or write the file again.`);
    }
    if (bytes.length > expected || crc32(bytes.subarray(16)) !== view.getUint32(12, true)) {
      throw new DataError("The data of this reach are damaged: their checksum does not match. Copy or write the file again.");
    }
    this.#buffer = buffer;
    this.#start = HEAD_BYTES + view.getUint32(20, true);
    const header = JSON.parse(new TextDecoder().decode(bytes.subarray(HEAD_BYTES, this.#start))) as {
      reach: unknown;
      sections: Section[];
    };
    this.reach = header.reach;
    for (const section of header.sections) this.#sections.set(section.name, section);
  }

  /** All arrays by their names. */
  get all(): Map<string, Numbers> {
    return new Map([...this.#sections.values()].map(({ name, type }) => [name, this.array(name, type as NumberType)]));
  }

  /** An array by its name, as a view of the bytes. */
  array<T extends NumberType>(name: string, type: T): ArrayOf<T> {
    const section = this.#sections.get(name);
    if (section === undefined || section.type !== type) {
      throw new DataError(`The data of this reach have no numbers “${name}” of type ${type}. Write the file again.`);
    }
    return new ARRAYS[type](this.#buffer, this.#start + section.offset, section.count) as ArrayOf<T>;
  }
}
