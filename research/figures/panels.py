# SPDX-License-Identifier: Apache-2.0
"""The parts of a figure, each drawn into axes of Matplotlib, and the paper's formulas that are drawn."""
import numpy as np
from matplotlib.colors import BoundaryNorm, FuncNorm, LinearSegmentedColormap, ListedColormap
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from stereogrid import plot

INK, PAPER, UNMATCHED = "#202226", "#fafaf8", "#c8cace"
UPRIGHT, ROAD = (230 / 255, 40 / 255, 40 / 255), (50 / 255, 110 / 255, 1)
# the paper's overlay, on P(T) before the Gaussian: a wall one bin deep hardly reaches 0.75 after it
UPRIGHT_ABOVE, FREE_BELOW, TINT = 0.75, 0.4, 0.5
DEPTHS_M = (1, 1.5, 2, 3, 4, 5, 7, 10, 20, 50)
COUNT_COLOURS = LinearSegmentedColormap.from_list("counts", ("#fcfcfa", "#fac882", "#e15a3c", "#82195a", "#190a32"))
# heights of obstacles in the scores against lidar
UPRIGHT_FROM_M, UPRIGHT_TO_M = 0.3, 1.8
SCAN_COLOURS = (("#c82e1e", f"{UPRIGHT_FROM_M:g} to {UPRIGHT_TO_M:g} m above the road"), ("#c8cace", "lower"),
                ("#4682c8", "higher"))
SEEN_OCCUPIED, HIDDEN_OCCUPIED, SEEN_FREE, HIDDEN = range(4)
TRUTH_COLOURS = ((INK, "obstacle, seen"), ("#cd8228", "obstacle, nothing of it seen"), ("#ffffff", "free, seen"),
                 ("#a0a2a6", "hidden"))


def legend_below(axes, colours):
    axes.legend(handles=[Patch(facecolor=colour, edgecolor=INK, linewidth=0.5, label=text) for colour, text in colours],
                loc="upper left", bbox_to_anchor=(0, -0.16), frameon=False, fontsize="small", handlelength=1)


def colour_bar(axes, image, label, ticks=None, pad=0.03):
    bar = axes.figure.colorbar(image, ax=axes, ticks=ticks, fraction=0.05, pad=pad)
    bar.set_label(label)
    bar.ax.minorticks_off()
    return bar


def surface(axes, function, x, y, labels, title):
    """A function of two numbers over two ranges, seen from above its nearest corner."""
    across, along = np.meshgrid(np.linspace(*x, 29), np.linspace(*y, 29))
    axes.plot_surface(across, along, function(across, along), cmap="viridis", vmin=0, vmax=1, rstride=1, cstride=1,
                      edgecolor="#00000060", linewidth=0.2)
    axes.view_init(elev=30, azim=-127.5)
    axes.set_box_aspect(None, zoom=0.92)  # room for the labels
    axes.set_facecolor("none")
    axes.set(title=title, xlabel=labels[0], ylabel=labels[1], zlabel=labels[2], zlim=(0, 1))


def contours(axes, function, x, y, labels, title):
    """The same as a map, with a line at every tenth."""
    across, along = np.meshgrid(np.linspace(*x, 301), np.linspace(*y, 301))
    values = function(across, along)
    image = axes.imshow(values, origin="lower", extent=(*x, *y), aspect="auto", cmap="viridis", vmin=0, vmax=1)
    axes.contour(across, along, values, levels=np.arange(1, 10) / 10, colors=PAPER, linewidths=0.7)
    axes.set(title=title, xlabel=labels[0], ylabel=labels[1])
    colour_bar(axes, image, labels[2])


def distances(axes, rig, largest_px):
    """Positions of distances among the disparities, without those too close to a neighbour."""
    right = axes.twinx()
    right.set_ylim(axes.get_ylim())
    marks = []
    for depth in DEPTHS_M:
        disparity = rig.focal_px * rig.baseline_m / depth
        if disparity < largest_px and (not marks or marks[-1][0] - disparity > 0.1 * largest_px):
            marks.append((disparity, f"{depth:g} m"))
    right.set_yticks([disparity for disparity, _ in marks], labels=[text for _, text in marks])


def u_disparity(axes, values, run, title, label, **colours):
    """An image of the u-disparity plane; the distance at the right."""
    half_bin = 0.5 * run.disparities / len(values)
    image = axes.imshow(values, aspect="auto", interpolation="nearest", **colours, extent=(
        -0.5, values.shape[1] - 0.5, run.disparities - half_bin, -half_bin))
    axes.set(title=title, xlabel="column u (px)", ylabel="disparity d (px)")
    distances(axes, run.rig, run.disparities)
    return colour_bar(axes, image, label, pad=0.12)  # the distances stand between


def probabilities(axes, values, run, title, label):
    u_disparity(axes, values, run, title, label, cmap="viridis", vmin=0, vmax=1)


def occupancies(axes, values, run, title):
    u_disparity(axes, values, run, title, "occupancy", cmap="gray_r", vmin=0, vmax=1)


def counts(axes, values, run, title):
    """Logarithmic: counts differ by orders of magnitude."""
    most = max(int(values.max()), 1)
    bar = u_disparity(axes, values, run, title, "pixels", cmap=COUNT_COLOURS, norm=FuncNorm((np.log1p, np.expm1), 0, most))
    bar.set_ticks([tick for tick in (0, 1, 3, 10, 30, 100, 300, 1000) if tick < 2 or tick < most])
    bar.ax.set_yticklabels([f"{tick:g}" for tick in bar.get_ticks()])


def from_above(axes, values, run, title, **colours):
    """Values [iy, ix] of a grid's cells in the vehicle frame: ahead is up, left is left."""
    plot.rulers(run.rig, run.grid, axes)
    image = plot.cells(run.grid, values, axes, **colours)
    axes.set(title=title, xlabel="to the left, y (m)", ylabel="ahead, x (m)")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(5, steps=(1, 2, 5, 10)))
    return image


def grid(axes, occupancy, run, title):
    colour_bar(axes, from_above(axes, occupancy, run, title, cmap="gray_r", vmin=0, vmax=1), "occupancy", ticks=(0, 0.5, 1))


def scan(axes, points, run, title):
    """Lidar returns from above, coloured by height; obstacles last, so that nothing hides them."""
    from_above(axes, np.zeros((run.grid.ny, run.grid.nx)), run, title, cmap="gray_r", vmin=0, vmax=1)
    upright = (points[:, 2] >= UPRIGHT_FROM_M) & (points[:, 2] < UPRIGHT_TO_M)
    low = points[:, 2] < UPRIGHT_FROM_M
    (upright_colour, _), (low_colour, _), (high_colour, _) = SCAN_COLOURS
    for chosen, colour in ((low, low_colour), (~low & ~upright, high_colour), (upright, upright_colour)):
        axes.scatter(points[chosen, 1], points[chosen, 0], s=1, color=colour, linewidths=0)
    legend_below(axes, SCAN_COLOURS)


def truth(axes, known, run, title):
    """Draws the true state of the cells and its visible part. `known`: state (0 hidden, 1 seen free, 2 seen occupied)
    and occupied."""
    state, occupied = known.state, known.occupied > 0
    shown = np.where(state == 2, SEEN_OCCUPIED, np.where(state == 1, SEEN_FREE,
                                                         np.where(occupied, HIDDEN_OCCUPIED, HIDDEN)))
    from_above(axes, shown, run, title, cmap=ListedColormap([colour for colour, _ in TRUTH_COLOURS]),
               norm=BoundaryNorm(np.arange(-0.5, 4), 4))
    legend_below(axes, TRUTH_COLOURS)


def camera(axes, image, title):
    height, width = image.shape[:2]
    axes.imshow(image, cmap="gray", vmin=0, vmax=1, extent=(-0.5, width - 0.5, height - 0.5, -0.5))
    axes.set(title=title, xlabel="column u (px)", ylabel="row v (px)")


def disparities(axes, stages, run, title):
    """Draws the disparities of obstacles and road; grey: no match."""
    obstacle, road = stages["obstacle_disparity"], stages["road_disparity"]
    matched = np.where(obstacle > 0, obstacle, road)
    height, width = matched.shape
    axes.set_facecolor(UNMATCHED)
    image = axes.imshow(np.ma.masked_equal(matched, 0), cmap="viridis", vmin=0, interpolation="nearest",
                        extent=(-0.5, width - 0.5, height - 0.5, -0.5))
    axes.set(title=title, xlabel="column u (px)", ylabel="row v (px)")
    colour_bar(axes, image, "disparity (px)")


def overlaid(image, occupancy, run, ground):
    """On the image, what the u-disparity plane says: a slab as high as the volume that must be free where a bin is
    occupied, blue on the road where it is free. `ground` as a frame's line has it."""
    rig, config = run.rig, run.bins
    height, width = image.shape
    v = np.arange(height)[:, None] - rig.cy_px + rig.focal_px * np.tan(ground["pitch_rad"])
    if config["follow_roll"]:
        v = v + np.tan(ground["roll_rad"]) * (np.arange(width) - rig.cx_px)
    v = np.broadcast_to(v, image.shape)  # rows below the horizon
    per_metre = rig.baseline_m * np.cos(ground["pitch_rad"]) * len(occupancy) / run.disparities  # bins per row
    bins = np.floor(v * per_metre / ground["height_m"] + 0.5).astype(int)
    on_plane = (bins > 0) & (bins < len(occupancy))
    road = np.where(on_plane, occupancy[np.where(on_plane, bins, 0), np.arange(width)], 0.5) < FREE_BELOW
    upright = np.zeros(image.shape, bool)
    for row in range(1, len(occupancy)):
        above = ground["height_m"] - v * per_metre / row  # over the road, of a pixel at this disparity
        upright |= (occupancy[row] > UPRIGHT_ABOVE) & (above >= 0) & (above <= config["obstacle_height_m"])
    picture = np.repeat(image[..., None], 3, axis=2)
    for chosen, colour in ((upright, UPRIGHT), (road & ~upright, ROAD)):
        picture[chosen] = (1 - TINT) * picture[chosen] + TINT * np.array(colour)
    return picture


# The paper's formulas. `config`: the group u_disparity of a run's config. A test compares them with what the pipeline computes.


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
