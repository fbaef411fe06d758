"""Renders a run of Halocline with ParaView, without a window:

    pvbatch scripts/view_paraview.py SOURCE [PICTURE.png] [--time SECONDS] [--field speed|velocity|density|pressure]

SOURCE is a run's directory, its snapshots/run.hdf.series or one snapshot. The fluid is drawn as spheres, by default
coloured by speed at the last time; the walls as an outline. Optional: needs ParaView 5.11 or later (Debian:
`apt-get install paraview python3-paraview`; on a machine without a display also `xvfb`, and then
`xvfb-run -a pvbatch ...`). The files open in ParaView's window just as they are; this script only saves the clicks.
"""

import argparse
import json
import os
import sys

from paraview import simple as pv


def files_of(source):
    """The snapshots and their times; the times of a single file are not known."""
    if os.path.isdir(source):
        source = os.path.join(source, "snapshots", "run.hdf.series")
    if not source.endswith(".series"):
        return [(None, source)]
    with open(source, encoding="utf-8") as file:
        entries = json.load(file)["files"]
    return [(entry["time"], os.path.join(os.path.dirname(source), entry["name"])) for entry in entries]


def particles_of_kind(reader, kind):
    threshold = pv.Threshold(Input=reader)
    threshold.Scalars = ["POINTS", "kind"]
    threshold.ThresholdMethod = "Between"
    threshold.LowerThreshold = threshold.UpperThreshold = kind
    return threshold


def main():
    parser = argparse.ArgumentParser(prog="pvbatch view_paraview.py")
    parser.add_argument("source")
    parser.add_argument("picture", nargs="?", default="paraview.png")
    parser.add_argument("--time", type=float, help="seconds; the nearest snapshot is taken (default: the last)")
    parser.add_argument("--field", default="speed", help="speed, or a field of the snapshots (default: speed)")
    options = parser.parse_args()

    files = files_of(options.source)
    time, path = files[-1]
    if options.time is not None and time is not None:
        time, path = min(files, key=lambda entry: abs(entry[0] - options.time))
    reader = pv.VTKHDFReader(FileName=[path])
    reader.UpdatePipeline()

    view = pv.CreateRenderView()
    view.ViewSize = [1600, 1000]
    view.UseColorPaletteForBackground = 0
    view.Background = [1, 1, 1]
    view.OrientationAxesVisibility = 0

    fluid = particles_of_kind(reader, 0)
    fluid.UpdatePipeline()
    if fluid.GetDataInformation().GetNumberOfPoints() == 0:
        sys.exit(f"view_paraview: no fluid in {path}")
    field = "velocity" if options.field == "speed" else options.field
    if fluid.PointData.GetArray(field) is None:
        sys.exit(f"view_paraview: {path} has no field {field}")
    number = fluid.GetDataInformation().GetNumberOfPoints()
    bounds = fluid.GetDataInformation().GetBounds()
    volume = 1.0
    for axis in range(3):
        volume *= bounds[2 * axis + 1] - bounds[2 * axis]

    display = pv.Show(fluid, view)
    display.SetRepresentationType("Point Gaussian")
    display.ShaderPreset = "Sphere"
    display.GaussianRadius = 0.5 * spacing_of(path, (volume / number) ** (1 / 3))
    pv.ColorBy(display, ("POINTS", field, "Magnitude") if field == "velocity" else ("POINTS", field))
    display.RescaleTransferFunctionToDataRange(True, False)
    colors = pv.GetColorTransferFunction(field)
    colors.ApplyPreset("Viridis (matplotlib)", True)
    bar = pv.GetScalarBar(colors, view)
    bar.Title = {"velocity": "speed, m/s", "density": "density, kg/m3", "pressure": "pressure, Pa"}.get(field, field)
    bar.ComponentTitle = ""
    bar.RangeLabelFormat = "%.3g"
    bar.WindowLocation = "Lower Right Corner"
    bar.TitleColor = bar.LabelColor = [0.1, 0.15, 0.2]
    display.SetScalarBarVisibility(view, True)

    walls = particles_of_kind(reader, 1)
    walls.UpdatePipeline()
    if walls.GetDataInformation().GetNumberOfPoints() > 0:
        outline = pv.Show(pv.Outline(Input=walls), view)
        outline.AmbientColor = outline.DiffuseColor = [0.35, 0.4, 0.45]

    bodies = particles_of_kind(reader, 2)
    bodies.UpdatePipeline()
    if bodies.GetDataInformation().GetNumberOfPoints() > 0:
        shown = pv.Show(bodies, view)
        shown.SetRepresentationType("Point Gaussian")
        shown.ShaderPreset = "Sphere"
        shown.GaussianRadius = display.GaussianRadius
        shown.AmbientColor = shown.DiffuseColor = [0.55, 0.53, 0.5]
        pv.ColorBy(shown, None)

    title = pv.Text(Text=os.path.basename(path) if time is None else f"t = {time:.2f} s")
    text = pv.Show(title, view)
    text.Color = [0.1, 0.15, 0.2]
    text.WindowLocation = "Upper Center"

    view.CameraViewUp = [0, 0, 1]
    view.CameraPosition = [0.42, -1.0, 0.38]
    view.CameraFocalPoint = [0, 0, 0]
    view.ResetCamera()
    view.GetActiveCamera().Dolly(1.05)
    pv.SaveScreenshot(options.picture, view)
    print(options.picture)


def spacing_of(path, estimate):
    """The particle spacing, from /Halocline where h5py can be had."""
    try:
        import h5py

        with h5py.File(path, "r") as file:
            return float(file["Halocline"].attrs["particle_spacing"])
    except (ImportError, KeyError, OSError):
        return estimate


main()
