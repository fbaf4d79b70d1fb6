// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <stereogrid/evaluation/motion.hpp>
#include <stereogrid/evaluation/scores.hpp>

#include <cstdio>

int main() {
  namespace evaluation = stereogrid::evaluation;
  const stereogrid::GridGeometry grid{3, 0, 1, 2, 1};
  stereogrid::Rig rig;
  rig.width_px = 10;
  rig.focal_px = 10;
  evaluation::Labels labels{grid, rig, {2, 1, evaluation::labelled_free}, {2, 1}};
  labels.cells(1, 0) = evaluation::labelled_occupied;
  stereogrid::Image<float> probability{2, 1, 0.1F};
  probability(1, 0) = 0.9F;
  evaluation::Scores scores;
  scores.add("only", probability.view(), labels);
  const double auc{scores.summary({3, 20}).auc.value};
  std::printf("AUC %.1f, %zu hidden objects\n", auc, evaluation::MotionScores{}.summary().hidden_episodes);
  return auc == 1 ? 0 : 1;
}
