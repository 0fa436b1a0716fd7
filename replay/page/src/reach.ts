// One reach in memory: what the program packed, as arrays, with the questions that the views ask.

import { DataError, type ReachData } from "./container.ts";

export interface Vector3 extends Array<number> {}

export type Category = string | { name: string; code: number };

export interface Shape {
  sphere?: { radius_m: number };
  cylinder?: { radius_m: number; length_m: number };
  capsule?: { radius_m: number; length_m: number };
  box?: { size_m: Vector3 };
  hull?: { points_m: Vector3[] };
}

export interface Pose {
  position: Vector3;
  orientation: Vector3;
}

export interface Body {
  owner: { link?: string; object?: number };
  parts: { shape: Shape; pose_body: Pose }[];
  rest_pose_world: Pose;
}

export interface ReachObject {
  kind: string;
  category: Category;
  position_world: Vector3;
  parameters: Record<string, number>;
}

export interface Patch {
  name: string;
  link: string;
  grid: { rows: number; columns: number; wraps: boolean } | null;
  first_taxel: number;
  taxels: number;
}

export interface Goal {
  position_world: Vector3;
  start_time_s: number;
  end_time_s: number;
  outcome: string;
}

export interface Contact {
  link: string;
  patch: number | null;
  object: number;
  first_frame: number;
  last_frame: number;
  peak_force_n: number;
  mean_force_n: number;
}

/** An obstacle on the controller's map, as it stood there from one frame to another. */
export interface MappedObstacle {
  kind: "fixed" | "doubtful" | "yielding";
  /** Upper end of its upright axis, m, world frame. */
  top_world: Vector3;
  radius_m: number;
  deviation_m: number;
  first_frame: number;
  last_frame: number;
}

export interface VerdictHeader {
  model: string;
  classifier: string;
  features: string[];
  patches: number[];
  threshold_n: number;
  /** The categories that the model knows. */
  categories: string[];
  /** What each score is about. */
  scores: string[];
  score_kind: "nats" | "probability";
  verdicts: string[];
  /** How a touch model decides; null for classifiers of trials. */
  touch: { nothing_above: number; unknown_share: number; cost_of_uncertain: number } | null;
}

/** What the program says about a reach besides the arrays; replay/src/pack.rs writes it. */
export interface Header {
  scene: string;
  controller: string;
  seed: string;
  reach_index: number;
  rate_hz: number;
  /** The number of the first frame that is here; not 0 for what follows the beginning of a running reach. */
  from: number;
  frames: number;
  outcome: string;
  goal_outcomes: { reached: number; stuck: number; timed_out: number; aborted: number };
  safety_stop: { object_index: number | null; object_kind: string; link: string; patch: string | null; force_n: number } | null;
  joint_names: string[];
  patches: Patch[];
  objects: ReachObject[];
  bodies: Body[];
  goals: Goal[];
  contacts: Contact[];
  /** The controller's map; empty if it keeps none. */
  map: MappedObstacle[];
  audit_warnings: string[];
  force_limit_n: number | null;
  threshold_n: number;
  verdicts: VerdictHeader | null;
}

export const NO_OBJECT = -1;

export function categoryName(category: Category): string {
  return typeof category === "string" ? category : category.name;
}

/** A reach with all its arrays. Taxels are numbered through all patches. */
export class Reach {
  readonly header: Header;
  readonly frames: number;
  readonly taxels: number;
  readonly time: Float64Array;
  readonly jointTorque: Float32Array;
  readonly tip: Float32Array;
  readonly goalPosition: Float32Array;
  readonly goalIndex: Uint16Array;
  readonly patchPose: Float32Array;
  readonly taxelPosition: Float32Array;
  readonly taxelNormal: Float32Array;
  readonly taxelTangent: Float32Array;
  readonly taxelArea: Float32Array;
  readonly readingStart: Uint32Array;
  readonly readingTaxel: Uint32Array;
  readonly sensed: Float32Array;
  readonly trueForce: Float32Array;
  readonly shear: Float32Array;
  readonly readingObject: Int16Array;
  readonly trackStart: Uint32Array;
  readonly trackFrame: Uint32Array;
  readonly trackPose: Float32Array;
  /** The patch of each taxel. */
  readonly patchOf: Uint16Array;

  constructor(readonly data: ReachData) {
    this.header = data.reach as Header;
    this.frames = this.header.frames;
    this.time = data.array("time_s", "f64");
    this.jointTorque = data.array("joint_torque_nm", "f32");
    this.tip = data.array("tip_pose_world", "f32");
    this.goalPosition = data.array("goal_position_world_m", "f32");
    this.goalIndex = data.array("goal_index", "u16");
    this.patchPose = data.array("patch_pose_world", "f32");
    this.taxelPosition = data.array("taxel_position_link_m", "f32");
    this.taxelNormal = data.array("taxel_normal_link", "f32");
    this.taxelTangent = data.array("taxel_tangent_link", "f32");
    this.taxelArea = data.array("taxel_area_m2", "f32");
    this.readingStart = data.array("reading_start", "u32");
    this.readingTaxel = data.array("reading_taxel", "u32");
    this.sensed = data.array("reading_sensed_n", "f32");
    this.trueForce = data.array("reading_true_n", "f32");
    this.shear = data.array("reading_shear_n", "f32");
    this.readingObject = data.array("reading_object", "i16");
    this.trackStart = data.array("track_start", "u32");
    this.trackFrame = data.array("track_frame", "u32");
    this.trackPose = data.array("track_pose_world", "f32");
    this.taxels = this.taxelArea.length;
    if (this.frames === 0) throw new DataError("This reach has no frames, so there is nothing to show.");
    this.patchOf = new Uint16Array(this.taxels);
    this.header.patches.forEach((patch, index) => {
      this.patchOf.fill(index, patch.first_taxel, patch.first_taxel + patch.taxels);
    });
  }

  /** Length, s. */
  get duration(): number {
    return this.time[this.frames - 1]!;
  }

  /** The last frame at or before a time, s. */
  frameAt(time: number): number {
    let [low, high] = [0, this.frames - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.time[middle]! <= time + 1e-9) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  /** The frame nearest to a time, s, which may be rounded. */
  frameNearest(time: number): number {
    const before = this.frameAt(time);
    const next = this.time[before + 1] ?? Number.POSITIVE_INFINITY;
    return next - time < time - this.time[before]! ? before + 1 : before;
  }

  /** The row of a taxel's reading in a frame, or -1. */
  reading(taxel: number, frame: number): number {
    return search(this.readingTaxel, taxel, this.readingStart[frame]!, this.readingStart[frame + 1]!);
  }

  /** The row of a body's stored pose in a frame, or -1 for its pose at rest. */
  track(body: number, frame: number): number {
    let [low, high] = [this.trackStart[body]!, this.trackStart[body + 1]!];
    const first = low;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.trackFrame[middle]! <= frame) low = middle + 1;
      else high = middle;
    }
    return low === first ? -1 : low - 1;
  }

  /** The category of an object by name; "spurious" for none, which is a reading that nothing causes. */
  category(object: number): string {
    const found = this.header.objects[object];
    return found === undefined ? "spurious" : categoryName(found.category);
  }

  /** Names of the categories of all objects, in the order of the objects. */
  get categories(): string[] {
    return [...new Set(this.header.objects.map((object) => categoryName(object.category)))];
  }

  patch(taxel: number): Patch {
    return this.header.patches[this.patchOf[taxel]!]!;
  }

  /** The patches that the model judges, by name, if it leaves others out. */
  get judgedAlone(): string | null {
    const judged = this.header.verdicts?.patches ?? [];
    if (judged.length === 0 || judged.length === this.header.patches.length) return null;
    return `patch${judged.length > 1 ? "es" : ""} ${judged.map((patch) => this.header.patches[patch]!.name).join(", ")}`;
  }

  /** The controller's map in a frame. */
  mapAt(frame: number): MappedObstacle[] {
    return this.header.map.filter(({ first_frame, last_frame }) => first_frame <= frame && frame <= last_frame);
  }

  /** Whether this was measured on a robot: without goals, true forces, places of objects and angles of joints. */
  get isLog(): boolean {
    return this.header.controller === "unknown";
  }

  /** Whether this is a table of contact trials: a log without an arm and without places of taxels. */
  get isTable(): boolean {
    return this.header.joint_names.length === 0;
  }

  /** A taxel as a person names it: "forearm row 3, column 12", or "flipper taxel 5" without a grid. */
  taxelName(taxel: number): string {
    const patch = this.patch(taxel);
    const index = taxel - patch.first_taxel;
    if (patch.grid === null || this.isTable) return `${patch.name} taxel ${index}`;
    return `${patch.name} row ${Math.floor(index / patch.grid.columns)}, column ${index % patch.grid.columns}`;
  }

  /** A taxel as addresses name it: "forearm.142". */
  taxelAddress(taxel: number): string {
    const patch = this.patch(taxel);
    return `${patch.name}.${taxel - patch.first_taxel}`;
  }

  objectName(object: number): string {
    const found = this.header.objects[object];
    return found === undefined ? "nothing" : `${found.kind.replace(/_/g, " ")} ${object}`;
  }
}

/** The place of a value in the ascending part [low, high) of an array, or -1. */
export function search(values: Uint32Array, value: number, low: number, high: number): number {
  while (low < high) {
    const middle = (low + high) >> 1;
    const found = values[middle]!;
    if (found === value) return middle;
    if (found < value) low = middle + 1;
    else high = middle;
  }
  return -1;
}
