# SPDX-License-Identifier: Apache-2.0
"""The paper's formulas, to draw them. `config`: the group u_disparity of a run's config. A test compares them with what
the pipeline computes."""
import numpy as np


def obstacle_confidence(observed_share, tau):
    """Eq. 13: P(C). The share r_O = N_O/N_V is the filled part of the visible rays."""
    return 1 - np.exp(-observed_share / tau)


def road_confidence(observed_share, road_share, config):
    """Eq. 15: P(R). The share r_R is that of road among the nine bins around."""
    return np.exp(-(1 - road_share) / config["tau_road"]) * np.exp(-observed_share / config["tau_obstacle"])


def obstacle_probability(visibility, confidence, config):
    """Eq. 8: P(O)."""
    found = confidence * (1 - config["false_positive"]) + (1 - confidence) * config["false_negative"]
    return visibility * found + (1 - visibility) / 2


def occupancy(obstacle, road, config):
    """Eq. 14: P(T), kept within what a sensor with errors can know."""
    return np.clip(obstacle * (1 - road), config["false_negative"], 1 - config["false_positive"])


def road_counts(road_disparity, rows, disparities):
    """Number of each column's road pixels by disparity: (rows, W). `disparities`: how many px all rows
    together cover. The whole column counts; row 0 is no measurement."""
    bins = np.floor(road_disparity * (rows / disparities) + 0.5).astype(int)
    counts = np.zeros((rows, road_disparity.shape[1]), int)
    v, u = np.nonzero((road_disparity > 0) & (bins > 0) & (bins < rows))
    np.add.at(counts, (bins[v, u], u), 1)
    return counts
