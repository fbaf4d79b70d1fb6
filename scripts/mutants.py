#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Usage: scripts/mutants.py [--jobs N] [--most N] [--out FILE]

Changes one token of src/ at a time, and runs the core's unit and chain tests: each change should fail one. Results are
added to FILE (build/mutants/results.txt), a line each: killed, survived, or broken (does not compile without warnings); mutants that it
has are skipped. Builds in build/mutants, from a copy of the working tree. docs/testing.md has the survivors.
"""
import argparse
import hashlib
import queue
import shutil
import subprocess
import sys
import threading
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
WORK = ROOT / "build" / "mutants"
TESTS = ["stereogrid_core_tests", "stereogrid_chain_tests"]
TEST_S = 900
AUDITED = 20  # number of audited changes, at the head of the list
# folder of src/: what most likely fails, and is run first
FIRST = {"motion": "SceneFlow*:EvidenceMap*:EgoMotion*:VelocityEvidence*", "obstacles": "Tracker*:Segments*:UprightRow*:ClusterVelocities*",
         "ground": "*Ground*:Mounting*:RoadSupport*:Levelling*", "observation": "Rays*:UDisparity*:Projection*:Grid*",
         "filter": "*Filter*:MovingBlocks*:Window*:Unseen*", "matching": "*Matching*:SemiGlobal*:*Given*:*Noise*:*Decision*",
         "images": "*Patch*:Alignment*:Level*", "terrain": "*Terrain*:*Drivable*:*Edges*"}

# file in src/ ¦ text that it has once ¦ text in its place
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
ground/relief.hpp ¦ sector_px{8}; ¦ sector_px{16};
ground/search.cpp ¦  (b.u - a.u)  ¦  (b.u + a.u) 
ground/search.cpp ¦ ) && best ¦ ) || best
ground/trust.cpp ¦ before) < least_grey ¦ before) > least_grey
ground/trust.cpp ¦ path_m{1}; ¦ path_m{2};
ground/trust.hpp ¦ samples >= ground_samples_min ¦ samples > ground_samples_min
ground/trust.hpp ¦ {0.85}; ¦ {0.425};
images/level_mapping.cpp ¦ )) + 1} ¦ )) - 1}
images/levelling.cpp ¦ 5 && u ¦ 5 || u
images/patch.cpp ¦ above + rows ¦ above - rows
images/patch.hpp ¦ patch_reach_v + 1} ¦ patch_reach_v - 1}
images/patch_formulas.hpp ¦ vv - patch ¦ vv + patch
images/patch_simd.cpp ¦ 0] + here ¦ 0] - here
images/row_alignment/cpu.cpp ¦ 8, 0, right.height - 1)) + u}; ¦ 8, 0, right.height - 1)) - u};
images/row_alignment/estimate.cpp ¦ {0.5}; ¦ {0.25};
images/row_alignment/model.hpp ¦ offset < 0  ¦ offset > 0 
images/row_alignment/reference.cpp ¦ height - 1) ¦ height + 1)
images/row_alignment/row_alignment.hpp ¦ alignment_columns{4}; ¦ alignment_columns{8};
images/turned_row.hpp ¦ centre_u + (u ¦ centre_u - (u
matching/checks/classify_simd.cpp ¦ data() + u)) ¦ data() - u))
matching/checks/external.hpp ¦ r && d ¦ r || d
matching/checks/mask.cpp ¦ {u > left ¦ {u < left
matching/checks/speckles.hpp ¦ 1 && road_px ¦ 1 || road_px
matching/checks/texture_simd.cpp ¦  columns + half + width ¦  columns - half + width
matching/checks/winner_formulas.hpp ¦ 0.02f)  ¦ 0.01f) 
matching/correlation/census_simd.cpp ¦ >> 8; } ¦ >> 16; }
matching/correlation/correlate_simd.cpp ¦ {v > band ¦ {v < band
matching/correlation/level_simd.hpp ¦ + 1) + u) : ¦ + 1) - u) :
matching/correlation/upright_block_simd.hpp ¦ ints, 1))) ¦ ints, 2)))
matching/correlation/upright_simd.hpp ¦ uint16_t{255}); ¦ uint16_t{510});
matching/match_lattice.hpp ¦ step_u{6}; ¦ step_u{12};
matching/matching.hpp ¦ road_margin_px + 1} ¦ road_margin_px - 1}
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
matching/surfaces_simd.hpp ¦ continues_left{2};  ¦ continues_left{4}; 
motion/ego_motion.cpp ¦ {0.3}; ¦ {0.15};
motion/scene_flow.cpp ¦ step - 1) ¦ step + 1)
motion/scene_flow.hpp ¦ remembered{6}; ¦ remembered{12};
motion/symmetric2.hpp ¦ squares - squared ¦ squares + squared
motion/velocity_evidence.cpp ¦ :min(point ¦ :max(point
numbers.hpp ¦ >> 1); ¦ >> 2);
observation/projection/cpu.cpp ¦ 0 ? 0.5f : highest ¦ 0 ? 0.25f : highest
observation/projection/model.hpp ¦ ix + 1) ¦ ix - 1)
observation/projection/projection.hpp ¦ levels{3}; ¦ levels{6};
observation/projection/reference.cpp ¦ highest < 0  ¦ highest > 0 
observation/rays/cpu.cpp ¦ counts + (u ¦ counts - (u
observation/rays/evidence_formulas.hpp ¦ 00138888889f ¦ 000694444445f
observation/rays/model.hpp ¦ first && row ¦ first || row
observation/rays/project_simd.cpp ¦ 0] - less ¦ 0] + less
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
obstacles/tracking/box.cpp ¦ growing{0.3}; ¦ growing{0.15};
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
terrain/gaps.cpp ¦  n + 0. ¦  n - 0.
terrain/model.hpp ¦ per_row - h) ¦ per_row + h)
terrain/relief.cpp ¦ expected) < std ¦ expected) > std
terrain/ring_view.cpp ¦  * (end_m - begin_m)  ¦  * (end_m + begin_m) 
terrain/rings.cpp ¦ ), 2 *  ¦ ), 4 * 
terrain/rules.hpp ¦ ruled_edge{0.7f}; ¦ ruled_edge{0.35f};
terrain/samples.cpp ¦ beside - s. ¦ beside + s.
terrain/samples.hpp ¦ tangent_at_row_0 + tangent_per_v ¦ tangent_at_row_0 - tangent_per_v
terrain/settle.cpp ¦ reach{24}; ¦ reach{2};
terrain/terrain.cpp ¦ obstacle, 3))  ¦ obstacle, 6)) 
terrain/walk.cpp ¦ is_continued && !is_first ¦ is_continued || !is_first
terrain/walk.cpp ¦ {0.5f  ¦ {0.25f 
terrain/walk.hpp ¦  z + slope ¦  z - slope
"""


def mutants() -> list:
    """Changes that an audit has found to survive first; the others in an order of chance that is the same each time, so
    that any first part is a sample."""
    found = [tuple(line.split(" ¦ ")) for line in MUTANTS.strip("\n").split("\n")]
    for file, before, _ in found:
        if (ROOT / "src" / file).read_text("utf-8").count(before) != 1:
            sys.exit(f"src/{file}: does not have '{before}' once. Correct the list in scripts/mutants.py.")
    return found[:AUDITED] + sorted(found[AUDITED:], key=lambda one: hashlib.sha256("".join(one).encode()).digest())


def run(*command, **options) -> bool:
    return subprocess.run(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False,
                          **options).returncode == 0


def copy_of_tree(job: int) -> Path:
    tree = WORK / f"tree-{job}"
    files = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT, check=True,
                           capture_output=True, text=True).stdout.split("\0")
    for name in filter(None, files):
        target = tree / name
        if (ROOT / name).is_file() and not (target.is_file() and target.read_bytes() == (ROOT / name).read_bytes()):
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, target)
    run("cmake", "-S", tree, "-B", tree / "build" / "release", "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
        "-DSTEREOGRID_TESTS=ON", "-DSTEREOGRID_HARDENING=OFF", "-DSTEREOGRID_WERROR=ON")
    return tree


def built(tree: Path) -> bool:
    return run("cmake", "--build", tree / "build" / "release", "--parallel", 1, "--target", *TESTS)


def passes(tree: Path, file: str = "") -> bool:
    programs = [(test, "*") for test in TESTS]
    if first := FIRST.get(file.split("/")[0]):
        programs.insert(0, (TESTS[0], first))
    try:
        return all(run(tree / "build" / "release" / "bin" / test, "--gtest_fail_fast", "--gtest_brief=1",
                       f"--gtest_filter={chosen}", timeout=TEST_S) for test, chosen in programs)
    except subprocess.TimeoutExpired:
        return False


def fate_of(tree: Path, mutant: tuple) -> str:
    file, before, after = mutant
    path = tree / "src" / file
    text = path.read_text("utf-8")
    path.write_text(text.replace(before, after), "utf-8")
    try:
        return "broken" if not built(tree) else "survived" if passes(tree, file) else "killed"
    finally:
        path.write_text(text, "utf-8")


def work(job: int, left: queue.Queue, out: Path):
    tree = copy_of_tree(job)
    if not built(tree) or (job == 0 and not passes(tree)):
        sys.exit("The tests fail without any change. Mend that first.")
    while True:
        try:
            mutant = left.get_nowait()
        except queue.Empty:
            return
        line = " ¦ ".join([fate_of(tree, mutant), *mutant])
        with out.open("a", encoding="utf-8") as file:
            file.write(line + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--most", type=int, default=len(MUTANTS))
    parser.add_argument("--out", type=Path, default=WORK / "results.txt")
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    known = options.out.read_text("utf-8").splitlines() if options.out.exists() else []
    done = {line.split(" ¦ ", 1)[1] for line in known}
    left = queue.Queue()
    for mutant in mutants()[:options.most]:
        if " ¦ ".join(mutant) not in done:
            left.put(mutant)
    threads = [threading.Thread(target=work, args=(job, left, options.out)) for job in range(options.jobs)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    fates = [line.split(" ¦ ", 1)[0] for line in options.out.read_text("utf-8").splitlines()]
    counts = {fate: fates.count(fate) for fate in ("killed", "survived", "broken")}
    share = counts["killed"] / max(1, counts["killed"] + counts["survived"])
    print(f"{counts}, {100 * share:.0f} % killed, of {len(mutants())} mutants")


main()
