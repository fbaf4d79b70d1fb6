#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Usage: scripts/mutants.py [--jobs N] [--only TEXT] [--out FILE]

Changes one token of src/ at a time, and runs the core's unit and chain tests: each change should fail one. A copy of the
working tree in build/mutants is built once, with all changes in it; STEREOGRID_MUTANT selects one at run time. Results are
added to FILE (build/mutants/results.txt), a line each: killed, survived, or broken (does not compile). Mutants that it has
are skipped. Prints the table of docs/testing.md.
"""
import argparse
import collections
import concurrent.futures
import os
import re
import resource
import shutil
import subprocess
import sys
import threading
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
WORK = ROOT / "build" / "mutants"
TREE = WORK / "tree"
BUILD = TREE / "build" / "release"
CORE, CHAIN = TESTS = ["stereogrid_core_tests", "stereogrid_chain_tests"]
WALL_S = 1800
# unit tests that take longest
SLOW = ("SceneFlow*:MountingSearch*:*HostileClock*:RigProblems*:*FilterOfEachModel*:Terrain*:Car*:*CallersResult*:"
        "MatchingTargets*:MatchingEquality*:Pipeline*:Projection*:*HostileInput*:Alignment*:SemiGlobal*:Matching.*:Subpixel*")
# folder of src/: those of them, and the chain tests, that most likely fail
FIRST = {"motion": ("SceneFlow*", "MotionChain*:Chain.*"), "obstacles": ("SceneFlow*", "*Standing*:MotionChain*"),
         "ground": ("MountingSearch*:RigProblems*", "GroundChain*:Mounting*:Trust*"),
         "observation": ("Projection*", "HalfHidden*:LowObstacles*"), "filter": ("*FilterOfEachModel*", "*Standing*:Chain.*"),
         "matching": ("Matching*:SemiGlobal*", "LowObstacles*:Chain.*"), "images": ("Alignment*", "AlignmentChain*"),
         "terrain": ("Terrain*:Car*", "Terrain*:LowObstacles*")}

# file in src/ ¦ text that it has once ¦ text in its place [¦ alone: needs a build of its own, since the value is used
# in a constant expression; equivalent: no test on this machine can detect it (docs/testing.md has the reason)]
MUTANTS = r"""
ground/mounting_search.cpp ¦ near >= 0.2 * all ¦ near >= 0.1 * all
ground/mounting_search.cpp ¦ 3 * below <= near ¦ 1 * below <= near
ground/mounting_search.cpp ¦ below <= 0.2 * all ¦ below <= 0.9 * all
motion/scene_flow.cpp ¦ clearly_best{0.8} ¦ clearly_best{1.0}
motion/scene_flow.cpp ¦ information_u_min{8} ¦ information_u_min{2}
motion/scene_flow.cpp ¦ row_error_max_px{1} ¦ row_error_max_px{3}
motion/scene_flow.cpp ¦ height_max_m{3} ¦ height_max_m{30}
motion/velocity_evidence.cpp ¦ weight_max{4} ¦ weight_max{8}
motion/velocity_evidence.cpp ¦ share_of_information{0.5} ¦ share_of_information{0.25}
motion/ego_motion.cpp ¦ (since_pose_s_ + before_s_) / 2 ¦ (since_pose_s_ + before_s_) / 1
obstacles/tracking/tracker.cpp ¦ another_thing{16} ¦ another_thing{36}
obstacles/tracking/tracker.cpp ¦ parted_within_m{0.7} ¦ parted_within_m{1.4}
obstacles/tracking/track_correction.cpp ¦ highest_mover_m{4.2} ¦ highest_mover_m{8.0}
obstacles/tracking/track_correction.cpp ¦ square / 2 - 2, ¦ square / 2 - 1,
obstacles/tracking/track_correction.cpp ¦ place_sigma_m{0.2} ¦ place_sigma_m{0.4}
obstacles/tracking/track_correction.cpp ¦ other_axes_rad{0.3} ¦ other_axes_rad{0.6}
observation/rays/weights.hpp ¦ log_odds_max{6.9f} ¦ log_odds_max{5.5f}
ground/fit_model.hpp ¦ settled_px{0.002} ¦ settled_px{0.02}
ground/fit_model.hpp ¦ least_px{0.4} ¦ least_px{0.8}
ground/fit_model.hpp ¦ sums.blocks < 4 ¦ sums.blocks < 2
config.cpp ¦ = {6, 6 ¦ = {12, 6
filter/bof2008/tay.cpp ¦ {x - tile_ ¦ {x + tile_
filter/bof2008/tay_simd.cpp ¦  + 1, next ¦  + 2, next
filter/cell_formulas.hpp ¦ {y - of ¦ {y + of
filter/cpu.cpp ¦ {x - cells ¦ {x + cells
filter/joint/active_blocks.cpp ¦ .y - around ¦ .y + around
filter/joint/active_blocks.hpp ¦ across + i} ¦ across - i}
filter/joint/even_model.hpp ¦  0.5f  ¦  0.25f 
filter/joint/evidence.cpp ¦  x - cells ¦  x + cells
filter/joint/evidence.hpp ¦  / 2) cell ¦  / 4) cell
filter/joint/evidence_simd.cpp ¦ block_cells + lane_; ¦ block_cells - lane_;
filter/joint/joint.cpp ¦ ) >= 0) ¦ ) > 0)
filter/joint/joint_before_simd.cpp ¦ (x + block_columns ¦ (x - block_columns
filter/joint/joint_simd.cpp ¦ block_rows < cells_ ¦ block_rows > cells_
filter/joint/joint_simd.hpp ¦ {x + joint ¦ {x - joint
filter/joint/joint_update_simd.cpp ¦ row.y) + x_)} ¦ row.y) - x_)}
filter/joint/moving_blocks.cpp ¦  + 1); ¦  + 2);
filter/joint/sparsity.cpp ¦ iy + 1) ¦ iy - 1)
filter/lattice_formulas.hpp ¦ xy + vy_mps ¦ xy - vy_mps
filter/model.hpp ¦ (1 - step ¦ (1 + step
filter/reference.cpp ¦ scale{1 /  ¦ scale{2 / 
filter/resampling/resample.cpp ¦  0.5f) ¦  0.25f)
filter/resampling/resample_model.hpp ¦ iy + 1), value ¦ iy + 2), value
filter/resampling/resample_rows.cpp ¦ nullptr && ! ¦ nullptr || !
filter/resampling/resample_simd.cpp ¦ y_, value(0.5f))}; ¦ y_, value(0.25f))};
filter/window.cpp ¦ return 1 -  ¦ return 2 - 
fusion/model.hpp ¦ ? 1 - surest ¦ ? 1 + surest
ground/fit.cpp ¦  * (1 - 5 ¦  * (2 - 5
ground/fit_model.hpp ¦ 1, 100, ¦ 1, 200,
ground/fit_model.hpp ¦ k >= distance_bins ¦ k > distance_bins
ground/matrix3.hpp ¦ 1] * a[1][2] - a[0][2] * a[ ¦ 1] * a[1][2] + a[0][2] * a[
ground/matrix3.hpp ¦ 2] + b[ ¦ 2] - b[
ground/model.hpp ¦ horizon + d  ¦ horizon - d 
ground/model.hpp ¦ per_v + gz ¦ per_v - gz
ground/mounting_search.cpp ¦ = 2.1; ¦ = 1.05;
ground/relief.hpp ¦ sector_px{8}; ¦ sector_px{16}; ¦ alone
ground/search.cpp ¦  (b.u - a.u)  ¦  (b.u + a.u) 
ground/search.cpp ¦ ) && best ¦ ) || best
ground/trust.cpp ¦ before) < least_grey ¦ before) > least_grey
ground/trust.cpp ¦ path_m{1}; ¦ path_m{2};
ground/trust.hpp ¦ samples >= ground_samples_min ¦ samples > ground_samples_min
ground/trust.hpp ¦ {0.85}; ¦ {0.425};
images/level_mapping.cpp ¦ )) + 1} ¦ )) - 1}
images/levelling.cpp ¦ 5 && u ¦ 5 || u
images/patch.cpp ¦ above + rows ¦ above - rows
images/patch.hpp ¦ patch_reach_v + 1} ¦ patch_reach_v - 1} ¦ alone
images/patch_formulas.hpp ¦ vv - patch ¦ vv + patch
images/patch_simd.cpp ¦ 0] + here ¦ 0] - here
images/row_alignment/cpu.cpp ¦ 8, 0, right.height - 1)) + u}; ¦ 8, 0, right.height - 1)) - u};
images/row_alignment/estimate.cpp ¦ {0.5}; ¦ {0.25};
images/row_alignment/model.hpp ¦ offset < 0  ¦ offset > 0 
images/row_alignment/reference.cpp ¦ height - 1) ¦ height + 1)
images/row_alignment/row_alignment.hpp ¦ alignment_columns{4}; ¦ alignment_columns{8}; ¦ alone
images/turned_row.hpp ¦ centre_u + (u ¦ centre_u - (u
matching/checks/classify_simd.cpp ¦ left_right_px + 1) ¦ left_right_px + 2)
matching/checks/external.hpp ¦ r && d ¦ r || d
matching/checks/mask.cpp ¦ {u > left ¦ {u < left
matching/checks/speckles.hpp ¦ 1 && road_px ¦ 1 || road_px
matching/checks/texture_simd.cpp ¦  columns + half + width ¦  columns - half + width
matching/checks/winner_formulas.hpp ¦ 0.02f)  ¦ 0.01f) 
matching/correlation/census_simd.cpp ¦ >> 8; } ¦ >> 16; } ¦ equivalent
matching/correlation/correlate_simd.cpp ¦ first_row - half - 1} ¦ first_row - half}
matching/correlation/upright_simd.hpp ¦ i <= half_ + 1; ++i) ¦ i <= half_; ++i)
matching/match_lattice.hpp ¦ step_u{6}; ¦ step_u{12};
matching/matching.hpp ¦ road_margin_px + 1} ¦ road_margin_px - 1} ¦ alone
matching/model.hpp ¦ width - 1 : ¦ width + 1 :
matching/padded.hpp ¦ first - border_ ¦ first + border_
matching/parameters.cpp ¦ 0.726f} ¦ 0.363f}
matching/reference.cpp ¦ best < shifts ¦ best > shifts
matching/semi_global/choose_simd.hpp ¦ costs + k)) ¦ costs - k))
matching/semi_global/cpu.cpp ¦ first_ + task_ ¦ first_ - task_
matching/semi_global/labels_simd.hpp ¦ middle - 1) ¦ middle + 1)
matching/semi_global/paths_simd.cpp ¦ count - meeting ¦ count + meeting
matching/semi_global/reference.cpp ¦ {at(before, k - 1), at(before, k) ¦ {at(before, k - 2), at(before, k)
matching/semi_global/semi_global.hpp ¦ meeting > 0  ¦ meeting < 0 
matching/surfaces_simd.cpp ¦ (df, labelled + u); ¦ (df, labelled - u);
matching/surfaces_simd.hpp ¦ continues_left{2};  ¦ continues_left{4};  ¦ alone
motion/ego_motion.cpp ¦ {0.3}; ¦ {0.15};
motion/scene_flow.cpp ¦ step - 1) ¦ step + 1)
motion/scene_flow.hpp ¦ remembered{6}; ¦ remembered{12}; ¦ alone
motion/symmetric2.hpp ¦ squares - squared ¦ squares + squared
motion/velocity_evidence.cpp ¦ :min(point ¦ :max(point
numbers.hpp ¦ >> 1); ¦ >> 2);
observation/projection/cpu.cpp ¦ 0 ? 0.5f : highest ¦ 0 ? 0.25f : highest
observation/projection/model.hpp ¦ ix + 1) ¦ ix - 1)
observation/projection/projection.hpp ¦ levels{3}; ¦ levels{6}; ¦ alone
observation/projection/reference.cpp ¦ highest < 0  ¦ highest > 0 
observation/rays/cpu.cpp ¦ counts + (u ¦ counts - (u
observation/rays/evidence_formulas.hpp ¦ 00138888889f ¦ 000694444445f
observation/rays/model.hpp ¦ first && row ¦ first || row
observation/rays/project_simd.cpp ¦ 0] - less ¦ 0] + less ¦ equivalent
observation/rays/reference.cpp ¦ obstacle > 0  ¦ obstacle < 0 
observation/rays/space.cpp ¦ bins + 1  ¦ bins - 1 
observation/rays/weights.hpp ¦  3.930f ¦  1.965f
observation/u_disparity/bin_formulas.hpp ¦ one - road ¦ one + road
observation/u_disparity/count_simd.cpp ¦ counts_ + (first ¦ counts_ - (first
observation/u_disparity/cpu.cpp ¦ (d + 1, ¦ (d - 1,
observation/u_disparity/infer_simd.cpp ¦ road_behind + u, ¦ road_behind - u,
observation/u_disparity/model.hpp ¦ {u + 1  ¦ {u - 1 
observation/u_disparity/reference.cpp ¦ (u + k, ¦ (u - k,
observation/u_disparity/rows.cpp ¦ image_height - 1)}; ¦ image_height - 2)};
observation/u_disparity/rows.hpp ¦  bins_of_row.data() + first_row(u); } ¦  bins_of_row.data() - first_row(u); }
observation/u_disparity/tables.cpp ¦ (k + 0. ¦ (k - 0.
obstacles/segmentation/clusters.hpp ¦ xx > 0; ¦ xx < 0;
obstacles/segmentation/drops.cpp ¦ sectors_apart_max{3} ¦ sectors_apart_max{6}
obstacles/segmentation/drops.cpp ¦ cells_apart_max{4} ¦ cells_apart_max{8}
obstacles/segmentation/drops.cpp ¦ points_min{3} ¦ points_min{1}
obstacles/segmentation/drops.cpp ¦ outline_points_max{24} ¦ outline_points_max{12}
obstacles/segmentation/drops.cpp ¦ (a.place.x - ¦ (a.place.x +
obstacles/segmentation/drops.cpp ¦ : 0.5) / ¦ : 0.25) /
obstacles/segmentation/near_columns.cpp ¦ filled_min{1.0 / ¦ filled_min{0.5 /
obstacles/segmentation/near_columns.cpp ¦ :max(frame ¦ :min(frame
obstacles/segmentation/near_obstacles.cpp ¦ {b.x - a.x, ¦ {b.x + a.x,
obstacles/segmentation/near_obstacles.cpp ¦ disparities - 1. ¦ disparities + 1.
obstacles/segmentation/pieces.cpp ¦ :min(near_bin ¦ :max(near_bin
obstacles/segmentation/pieces.cpp ¦  std::max(most.y ¦  std::min(most.y
obstacles/segmentation/segments.cpp ¦ cx_px - u) ¦ cx_px + u)
obstacles/segmentation/segments.cpp ¦ max(2, clamped_to_int ¦ max(4, clamped_to_int
obstacles/segmentation/segments.hpp ¦ bins_per_px{2}; ¦ bins_per_px{4};
obstacles/segmentation/segments.hpp ¦ far_m{40}; ¦ far_m{80};
obstacles/segmentation/shapes.cpp ¦ .x + c  ¦ .x - c 
obstacles/segmentation/shapes.cpp ¦ high_m{3.6}; ¦ high_m{1.8};
obstacles/segmentation/upright_row.cpp ¦ u] + edge_step_px ¦ u] - edge_step_px
obstacles/segmentation/upright_row_simd.cpp ¦ () + (begin ¦ () - (begin
obstacles/segmentation/velocities.cpp ¦ {0.2};  ¦ {0.1}; 
obstacles/segmentation/velocities.cpp ¦ {n < many ¦ {n > many
obstacles/tracking/box.cpp ¦ sigma_m < unknown ¦ sigma_m > unknown
obstacles/tracking/box.cpp ¦ following{0.3}; ¦ following{0.15};
obstacles/tracking/box.hpp ¦ 1] - reach_m ¦ 1] + reach_m
obstacles/tracking/motion_state.cpp ¦ 2] += q * dt_s / 2; ¦ 2] += q * dt_s / 4;
obstacles/tracking/motion_state.cpp ¦ 1] + half_s ¦ 1] - half_s
obstacles/tracking/motion_state.hpp ¦ at(2, 3 ¦ at(4, 3
obstacles/tracking/track_correction.cpp ¦ width_m - before ¦ width_m + before
obstacles/tracking/track_report.cpp ¦ moving >= surely_moving ¦ moving > surely_moving
obstacles/tracking/tracker.cpp ¦ y{std::max(other.least ¦ y{std::min(other.least
obstacles/tracking/tracker.cpp ¦ .x - other ¦ .x + other
obstacles/tracking/tracking.hpp ¦ surely_moving{3}; ¦ surely_moving{6};
obstacles/tracking/tracking.hpp ¦ evidence_of_frame{1.5} ¦ evidence_of_frame{0.75}
occupancy_values.cpp ¦  occupancy >= occupied_from ¦  occupancy > occupied_from
pipeline/checks.cpp ¦ cell_size_m > 0, ¦ cell_size_m < 0,
pipeline/frame_clock.cpp ¦ dt_s <= gap_max_s_ ¦ dt_s < gap_max_s_
pipeline/frame_clock.hpp ¦ last_ns_ && * ¦ last_ns_ || *
pipeline/frame_pipeline.cpp ¦ height_m) > 0. ¦ height_m) < 0.
pipeline/frame_pipeline.cpp ¦ {0.8}; ¦ {0.4};
pipeline/frame_pipeline.hpp ¦ scene_flow && ! ¦ scene_flow || !
pipeline/host_stages.hpp ¦ observed.fill(0.5f); ¦ observed.fill(0.25f);
pipeline/pipeline.cpp ¦  - 1, last_row ¦  - 2, last_row
pipeline/results.cpp ¦  / 2, config ¦  / 4, config
pixel_view.cpp ¦  - 8}; ¦  - 16};
points.cpp ¦ obstacle(u, v) > 0) { ¦ obstacle(u, v) < 0) {
terrain/frame_terrain.cpp ¦ raised_m > raised_m ¦ raised_m < raised_m
terrain/frame_terrain.cpp ¦ min_height_m / 2 ¦ min_height_m / 4
terrain/rules.hpp ¦ CellRule::obstacle ? 0.5f : 0.0f ¦ CellRule::obstacle ? 0.25f : 0.0f
terrain/gaps.cpp ¦  n + 0. ¦  n - 0.
terrain/gaps.cpp ¦ jump_min_px{0.9f} ¦ jump_min_px{1.8f}
terrain/gaps.cpp ¦ landing_samples_min{6} ¦ landing_samples_min{18}
terrain/gaps.cpp ¦ trench_begin_sigmas{1} ¦ trench_begin_sigmas{2}
terrain/gaps.cpp ¦ trench_depth_sigmas{2.5f} ¦ trench_depth_sigmas{5.0f}
terrain/gaps.cpp ¦ trench_depth_steps{0.3f} ¦ trench_depth_steps{0.6f}
terrain/gaps.cpp ¦ trench_wall_growth{0.5f} ¦ trench_wall_growth{1.0f}
terrain/gaps.cpp ¦ trench_wall_rows{4} ¦ trench_wall_rows{8}
terrain/gaps.cpp ¦ per_row < 0.35f * ¦ per_row < 0.7f *
terrain/gaps.cpp ¦ per_row > 0.6f * ¦ per_row > 0.3f *
terrain/gaps.cpp ¦ front.z - gap.landing_z ¦ front.z + gap.landing_z
terrain/gaps.cpp ¦ edge_x < 1.3f ¦ edge_x < 2.6f
terrain/gaps.cpp ¦ edge_x > 2 * ¦ edge_x > 1 *
terrain/gaps.cpp ¦ front.last_row - 3 * ¦ front.last_row - 6 *
terrain/gaps.cpp ¦ lowest_d - d ¦ lowest_d + d
terrain/gaps.cpp ¦ v <= front.last_row) return ¦ v >= front.last_row) return
terrain/model.hpp ¦ per_row - h) ¦ per_row + h)
terrain/relief.cpp ¦ expected) < std ¦ expected) > std
terrain/relief.cpp ¦ 4 * ground_ahead ¦ 2 * ground_ahead
terrain/ring_view.cpp ¦  * (end_m - begin_m)  ¦  * (end_m + begin_m) 
terrain/rings.cpp ¦ ), 2 *  ¦ ), 4 * 
terrain/rules.hpp ¦ ruled_edge{0.7f}; ¦ ruled_edge{0.35f};
terrain/samples.cpp ¦ beside - s. ¦ beside + s.
terrain/samples.hpp ¦ tangent_at_row_0 + tangent_per_v ¦ tangent_at_row_0 - tangent_per_v
terrain/settle.cpp ¦ reach{24}; ¦ reach{2};
terrain/settle.cpp ¦ neighbour_rings{3}; ¦ neighbour_rings{6};
terrain/settle.cpp ¦ widest_passage{0.25f} ¦ widest_passage{0.5f}
terrain/settle.cpp ¦ edge_confirmations{3} ¦ edge_confirmations{5}
terrain/settle.cpp ¦ ring + neighbour_rings) ¦ ring - neighbour_rings)
terrain/settle.cpp ¦ right - left - 1 ¦ right - left + 1
terrain/settle.cpp ¦ walk.end_seen + 1 ¦ walk.end_seen - 1
terrain/settle.cpp ¦ spread_sectors{8} ¦ spread_sectors{2}
terrain/terrain.cpp ¦ obstacle, 3))  ¦ obstacle, 6)) 
terrain/terrain.cpp ¦ judged_sigmas{3} ¦ judged_sigmas{6}
terrain/walk.cpp ¦ is_continued && !is_first ¦ is_continued || !is_first
terrain/walk.cpp ¦ {0.5f  ¦ {0.25f 
terrain/walk.cpp ¦ passage_end_rings{1} ¦ passage_end_rings{3}
terrain/walk.cpp ¦ passage_width{0.4f} ¦ passage_width{0.8f}
terrain/walk.cpp ¦ slope_memory_m{0.8f} ¦ slope_memory_m{1.6f}
terrain/walk.cpp ¦ is_far() ? 4 : 3 ¦ is_far() ? 4 : 1
terrain/walk.cpp ¦ gap.landing_z, 0.0f ¦ gap.landing_z, 0.5f
terrain/walk.hpp ¦  z + slope ¦  z - slope
"""

# Included in front of every source.
SWITCH = """#pragma once
#include <cstdlib>
namespace mutants {
inline const int chosen{std::getenv("STEREOGRID_MUTANT") != nullptr ? std::atoi(std::getenv("STEREOGRID_MUTANT")) : 0};
template <int number> constexpr bool is_chosen() { return chosen == number; }
}
"""


def mutants() -> list:
    found = [tuple((line + " ¦ ").split(" ¦ ")[:4]) for line in MUTANTS.strip("\n").split("\n")]
    for file, before, *_ in found:
        if (ROOT / "src" / file).read_text("utf-8").count(before) != 1:
            sys.exit(f"src/{file}: does not have '{before}' once. Correct the list in scripts/mutants.py.")
    return found


def expression_around(text: str, at: int) -> tuple:
    """Begin and end of the largest expression between brackets, commas and semicolons."""
    begin, end = at, at
    depth = 0
    while depth or not (text[begin - 1] in "({[,;" or re.search(r"(return|[^=<>!]=)\s$", text[begin - 8:begin])):
        begin -= 1
        depth += (text[begin] in ")}]") - (text[begin] in "({[")
    depth = 0
    while depth or text[end] not in ")}],;":
        depth += (text[end] in "({[") - (text[end] in ")}]")
        end += 1
    return begin, end


def switched_text(text: str, changes: list) -> str:
    """The text of a file with all of its changes, each where its number is chosen."""
    places = collections.defaultdict(list)  # expression: number and changed expression
    for number, before, after in changes:
        at = text.index(before) + len(os.path.commonprefix([before, after]))
        begin, end = expression_around(text, at)
        places[begin, end].append((number, text.index(before), before, after))
    outer = {}
    for begin, end in sorted(places, key=lambda place: (place[0], -place[1])):
        around = next((place for place in outer if place[0] <= begin and end <= place[1]), (begin, end))
        outer.setdefault(around, []).extend(places[begin, end])
    for (begin, end), found in sorted(outer.items(), reverse=True):
        switch = f"({text[begin:end]})"
        for number, at, before, after in found:
            changed = (text[:at] + after + text[at + len(before):])[begin:end + len(after) - len(before)]
            switch = f"(mutants::is_chosen<{number}>() ? ({changed}) : {switch})"
        line = text.rfind("\n", 0, begin) + 1
        # a constant would be evaluated at compile time
        head = re.sub(r"(static )?constexpr (?=[\w:<>]+ \w+( = |{))",
                      lambda found: "inline static const " if found[1] else "const ", text[line:begin])
        text = text[:line] + head + switch + text[end:]
    return text


def run(*command, **options) -> bool:
    return subprocess.run(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False,
                          **options).returncode == 0


def write(path: Path, text: str):
    if not path.is_file() or path.read_text("utf-8") != text:
        path.write_text(text, "utf-8")


def copy_tree(switched: list):
    """Copies the working tree, with switches in it."""
    names = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT, check=True,
                           capture_output=True, text=True).stdout.split("\0")
    changes = collections.defaultdict(list)
    for number, (file, before, after, _) in switched:
        changes[f"src/{file}"].append((number, before, after))
    for name in filter(lambda name: name and (ROOT / name).is_file(), names):
        (TREE / name).parent.mkdir(parents=True, exist_ok=True)
        if name not in changes:
            if not (TREE / name).is_file() or (TREE / name).read_bytes() != (ROOT / name).read_bytes():
                shutil.copyfile(ROOT / name, TREE / name)
            continue
        write(TREE / name, switched_text((ROOT / name).read_text("utf-8"), changes[name]))
    write(WORK / "switch.hpp", SWITCH)


def built() -> bool:
    return run("cmake", "--build", BUILD, "--parallel", 2, "--target", *TESTS)


def passes(test: str, chosen: str, number: int, cpu_s: float) -> bool:
    def limit():
        resource.setrlimit(resource.RLIMIT_CPU, (int(cpu_s), int(cpu_s)))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    try:
        return run("nice", "-n", 10, BUILD / "bin" / test, "--gtest_fail_fast", "--gtest_brief=1",
                   f"--gtest_filter={chosen}", timeout=WALL_S, preexec_fn=limit, cwd=WORK,
                   env=os.environ | {"STEREOGRID_MUTANT": str(number)})
    except subprocess.TimeoutExpired:
        return False


def cpu_of_tests() -> dict:
    """CPU time of each test program without any change."""
    found = {}
    for test in TESTS:
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        if not passes(test, "*", 0, WALL_S):
            sys.exit(f"{test} fails without any change. Mend that first.")
        found[test] = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return found


def fate_of(file: str, number: int, cpu_s: dict) -> str:
    slow, chain = FIRST.get(file.split("/")[0], ("Pipeline*", "Chain.*"))
    steps = [(CORE, f"*-{SLOW}"), (CORE, slow), (CHAIN, chain), (CORE, f"{SLOW}-{slow}"), (CHAIN, f"*-{chain}")]
    return "survived" if all(passes(*step, number, 20 + 3 * cpu_s[step[0]]) for step in steps) else "killed"


def fate_of_own_build(file: str, before: str, after: str, cpu_s: dict) -> str:
    path = TREE / "src" / file
    kept = path.read_text("utf-8")
    path.write_text((ROOT / "src" / file).read_text("utf-8").replace(before, after), "utf-8")
    try:
        return fate_of(file, 0, cpu_s) if built() else "broken"
    finally:
        path.write_text(kept, "utf-8")


def print_fates(fates: dict, listed: list):
    """A table by folder, as docs/testing.md has it."""
    columns = ["killed", "survived", "equivalent", "broken", "not run"]
    counts = collections.defaultdict(collections.Counter)
    for file, before, after, note in listed:
        fate = "equivalent" if note == "equivalent" else fates.get(" ¦ ".join([file, before, after]), "not run")
        for row in (file.split("/")[0] if "/" in file else "others", "all"):
            counts[row][fate] += 1
    print("| folder | " + " | ".join(columns) + " |\n" + "|---" * 6 + "|")
    for row in sorted(counts, key=lambda row: (row == "all", row)):
        print(f"| {row} | " + " | ".join(str(counts[row][column]) for column in columns) + " |")
    of = counts["all"]
    print(f"{100 * of['killed'] / max(1, of['killed'] + of['survived']):.0f} % killed")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--only", default="", help="changes whose line in the list has this text")
    parser.add_argument("--out", type=Path, default=WORK / "results.txt")
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    fates = {}
    for line in options.out.read_text("utf-8").splitlines() if options.out.exists() else []:
        fate, mutant = line.split(" ¦ ", 1)
        fates[mutant] = fate
    numbered = list(enumerate(mutants(), 1))
    switched = [one for one in numbered if one[1][3] != "alone"]
    copy_tree(switched)
    run("cmake", "-S", TREE, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_CXX_FLAGS_RELEASE=-O2 -DNDEBUG",
        "-DSTEREOGRID_TESTS=ON", "-DSTEREOGRID_HARDENING=OFF", "-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON",
        f"-DCMAKE_CXX_FLAGS=-include {WORK / 'switch.hpp'} -w -Wno-narrowing")
    if not built():
        sys.exit("The copy in build/mutants/tree does not compile. Give the change that it fails at a build of its own.")
    cpu_s = cpu_of_tests()
    lock = threading.Lock()

    def report(mutant: tuple, fate: str):
        with lock, options.out.open("a", encoding="utf-8") as file:
            file.write(" ¦ ".join([fate, *mutant[:3]]) + "\n")
            fates[" ¦ ".join(mutant[:3])] = fate

    left = [one for one in numbered if " ¦ ".join(one[1][:3]) not in fates and options.only in " ¦ ".join(one[1])]
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(lambda one: report(one[1], fate_of(one[1][0], one[0], cpu_s)), [one for one in left if not one[1][3]]))
    for _, mutant in filter(lambda one: one[1][3] == "alone", left):
        report(mutant, fate_of_own_build(*mutant[:3], cpu_s))
    print_fates(fates, mutants())


main()
