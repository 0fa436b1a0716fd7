// Which plots there are for a reach and a chosen taxel.

import type { Loaded } from "./pane.ts";
import { CATEGORY, type Curve, type PlotData } from "./plots.ts";
import type { Reach } from "./reach.ts";
import type { Series } from "./series.ts";
import type { Trials } from "./trials.ts";

/** Colours of joints, told apart by colour-blind readers (Okabe and Ito). */
const JOINTS = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#8a8f98"];

/** Values of another reach at the times of this one; none where it has ended. */
function at(reach: Reach, other: Loaded, values: Float64Array): (number | null)[] {
  return Array.from(reach.time, (time) => (time > other.reach.duration + 0.005 ? null : values[other.reach.frameAt(time)]!));
}

export function plotsOf(reach: Reach, trials: Trials, series: Series, taxel: number | null, second: Loaded | null): PlotData[] {
  const { time } = reach;
  const { force_limit_n: limit, joint_names: joints, verdicts } = reach.header;
  const beside = (read: (series: Series) => Float64Array): Curve[] => {
    return second === null ? [] : [{ name: "beside", colour: "second", dash: true, values: at(reach, second, read(second.series)) }];
  };
  const plots: PlotData[] = [
    {
      id: "force", title: "Largest force of a taxel", unit: "N", time, fromZero: true,
      curves: [{ name: "sensed", colour: "accent", values: series.largest }, { name: "true", colour: "quiet", dash: true, values: series.largestTrue }, ...beside((own) => own.largest)],
      level: limit === null ? null : { value: limit, name: "limit" },
    },
    { id: "area", title: "Contact area", unit: "cm²", time, fromZero: true, curves: [{ name: "area", colour: "accent", values: series.area }, ...beside((own) => own.area)] },
    {
      id: "torque", title: "Joint torques", unit: "N m", time, fromZero: false,
      curves: series.torque.map((values, joint) => ({ name: joints[joint]!.replace(/_/g, " "), colour: JOINTS[joint % JOINTS.length]!, dash: joint >= JOINTS.length, values })),
    },
    { id: "distance", title: "Distance from the goal", unit: "cm", time, fromZero: true, curves: [{ name: "distance", colour: "accent", values: series.distance }, ...beside((own) => own.distance)] },
  ];
  // A log has sensed forces and areas only, and a table of trials no areas.
  if (reach.isLog) {
    plots.length = reach.isTable ? 1 : 2;
    plots[0]!.curves = plots[0]!.curves.filter(({ name }) => name !== "true");
  }
  if (reach.header.goals.length === 0) plots.splice(3);
  if (taxel === null) return plots;
  const own = (values: Float32Array) => Array.from(time, (_, frame) => {
    const row = reach.reading(taxel, frame);
    return row < 0 ? 0 : values[row]!;
  });
  plots.push({
    id: "taxel", title: `Force on ${reach.taxelName(taxel)}`, unit: "N", time, fromZero: true,
    curves: [{ name: "sensed", colour: "accent", values: own(reach.sensed) }, ...(reach.isLog ? [] : [{ name: "true", colour: "quiet", dash: true, values: own(reach.trueForce) }])],
  });
  if (verdicts !== null && verdicts.patches.includes(reach.patchOf[taxel]!)) {
    const count = verdicts.scores.length;
    const shares = verdicts.score_kind === "probability";
    plots.push({
      id: "scores", title: `${shares ? "Probabilities" : "Scores"} of ${reach.taxelName(taxel)}`, unit: shares ? null : "nats", time, fromZero: shares,
      curves: verdicts.scores.map((name, index) => ({
        name, colour: `${CATEGORY}${name}`, dash: index % 2 === 1,
        values: Array.from(time, (_, frame) => {
          const row = trials.verdict(taxel, frame)?.row;
          return row === undefined ? null : trials.verdictScore[row * count + index]!;
        }),
      })),
    });
  }
  return plots;
}
