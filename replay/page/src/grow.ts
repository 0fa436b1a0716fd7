// A reach that runs: joins what is known with what the server sends of the frames since.

import { type ArrayOf, type Container, DataError, type Numbers, type NumberType, type ReachData } from "./container.ts";
import type { Contact, Header, Reach } from "./reach.ts";

/** Arrays whose numbers are rows of other arrays, counted from the first that was sent. */
const STARTS = ["reading_start", "verdict_start", "touch_start"];

/** Arrays in memory. */
class Joined implements ReachData {
  constructor(readonly reach: Header, readonly all: Map<string, Numbers>) {}

  array<T extends NumberType>(name: string, _type: T): ArrayOf<T> {
    const found = this.all.get(name);
    if (found === undefined) throw new DataError(`The data of this reach have no numbers “${name}”. Load the page again.`);
    return found as ArrayOf<T>;
  }
}

type Rows = ArrayOf<"u32">;

/** An array with the numbers of these parts, of the type of the first. */
function concat(parts: Numbers[]): Numbers {
  const made = parts[0]!.constructor as new (count: number) => Numbers;
  const out = new made(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    out.set(part, at);
    at += part.length;
  }
  return out;
}

/** Row numbers of both, of which the second count from the last of the first. */
function joinStarts(before: Rows, after: Rows): Numbers {
  const rows = before[before.length - 1]!;
  return concat([before, after.subarray(1).map((row) => row + rows)]);
}

/** What is known of a reach, together with what follows. `piece` must begin where the known frames end. */
export function join(known: Reach, piece: Container): ReachData {
  const header = piece.reach as Header;
  if (header.from === 0) return piece;
  if (header.from !== known.frames) {
    throw new DataError(`Frames ${known.frames} to ${header.from} of the running reach are missing. Load the page again.`);
  }
  const all = new Map(known.data instanceof Joined ? known.data.all : (known.data as Container).all);
  const more = piece.all;
  const [tracks, trials] = [joinTracks(all, more), joinTrials(all, more, known)];
  for (const [name, numbers] of more) {
    const before = all.get(name);
    if (before === undefined) throw new DataError(`The running reach has new numbers “${name}”. Load the page again.`);
    all.set(name, STARTS.includes(name) ? joinStarts(before as Rows, numbers as Rows) : concat([before, numbers]));
  }
  for (const [name, numbers] of [...tracks, ...trials]) all.set(name, numbers);
  return new Joined({ ...known.header, ...header, contacts: joinContacts(known.header.contacts, header) }, all);
}

/** Adds new contacts. The last known contact comes with the update again, because it may have gone on. */
function joinContacts(known: Contact[], { from, contacts }: Header): Contact[] {
  const ended = known.filter((contact) => contact.last_frame + 1 < from);
  return [...ended, ...contacts].sort((a, b) => a.first_frame - b.first_frame);
}

/** Pose tracks, grouped by body. */
function joinTracks(known: Map<string, Numbers>, more: Map<string, Numbers>): Map<string, Numbers> {
  const [before, after] = [known.get("track_start") as Rows, more.get("track_start") as Rows];
  const each = (name: string, width: number) => {
    const [old, news] = [known.get(name)!, more.get(name)!];
    const parts: Numbers[] = [];
    for (let body = 0; body + 1 < before.length; body++) {
      parts.push(old.subarray(width * before[body]!, width * before[body + 1]!), news.subarray(width * after[body]!, width * after[body + 1]!));
    }
    return concat([old.subarray(0, 0), ...parts]);
  };
  return new Map<string, Numbers>([
    ["track_start", before.map((row, body) => row + after[body]!)],
    ["track_frame", each("track_frame", 1)],
    ["track_pose_world", each("track_pose_world", 7)],
  ]);
}

const TRIALS = ["trial_taxel", "trial_first_frame", "trial_object", "trial_sample_start"];
const SAMPLES = ["sample_motion_m", "sample_region_taxels", "sample_region_force_n"];

interface Course {
  taxel: number;
  first: number;
  object: number;
  /** Its samples: rows of the known arrays, then of the new ones. */
  rows: [number, number][];
}

function coursesOf(arrays: Map<string, Numbers>): Course[] {
  const [taxels, firsts, objects, starts] = TRIALS.map((name) => arrays.get(name)!) as [Numbers, Numbers, Numbers, Numbers];
  return Array.from(taxels, (taxel, index) => ({ taxel, first: firsts[index]!, object: objects[index]!, rows: [[starts[index]!, starts[index + 1]!]] }));
}

/** Contact trials. An open trial's new samples come with the update. */
function joinTrials(known: Map<string, Numbers>, more: Map<string, Numbers>, { patchOf }: Reach): Map<string, Numbers> {
  const all = coursesOf(known).map((course) => ({ ...course, rows: [course.rows[0]!, [0, 0]] as [number, number][] }));
  const key = ({ taxel, first }: Course) => `${taxel} ${first}`;
  const places = new Map(all.map((course) => [key(course), course]));
  for (const news of coursesOf(more)) {
    const own = places.get(key(news));
    if (own === undefined) all.push({ ...news, rows: [[0, 0], news.rows[0]!] });
    else [own.object, own.rows[1]] = [news.object, news.rows[0]!];
  }
  // In the order of the program.
  all.sort((a, b) => patchOf[a.taxel]! - patchOf[b.taxel]! || a.first - b.first || a.taxel - b.taxel);
  const starts = [0];
  for (const { rows } of all) starts.push(starts[starts.length - 1]! + rows.reduce((sum, [from, to]) => sum + to - from, 0));
  const samples = SAMPLES.map((name): [string, Numbers] => {
    const sources = [known.get(name)!, more.get(name)!];
    return [name, concat([sources[0]!.subarray(0, 0), ...all.flatMap(({ rows }) => rows.map(([from, to], source) => sources[source]!.subarray(from, to)))])];
  });
  return new Map<string, Numbers>([
    ["trial_taxel", Uint32Array.from(all, ({ taxel }) => taxel)],
    ["trial_first_frame", Uint32Array.from(all, ({ first }) => first)],
    ["trial_object", Int16Array.from(all, ({ object }) => object)],
    ["trial_sample_start", Uint32Array.from(starts)],
    ...samples,
  ]);
}
