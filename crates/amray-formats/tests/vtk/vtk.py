"""What VTK itself makes of files, for the tests: `read DIRECTORY` prints what is in the AMR files there, `write DIRECTORY`
writes images and AMR data in every encoding and prints their names."""

import itertools
import os
import sys

import numpy
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import (
    vtkAMRBox,
    vtkAMRUtilities,
    vtkImageData,
    vtkOverlappingAMR,
    vtkStructuredData,
    vtkUniformGrid,
)
from vtkmodules.vtkIOHDF import vtkHDFReader
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter, vtkXMLUniformGridAMRReader, vtkXMLUniformGridAMRWriter


def read(directory):
    for name in ["cells.vthb", "cells.vtkhdf", "nodes.vthb", "nodes.vtkhdf"]:
        reader = vtkHDFReader() if name.endswith("hdf") else vtkXMLUniformGridAMRReader()
        reader.SetFileName(os.path.join(directory, name))
        if name.endswith("hdf"):
            # 0 is no limit; without it the coarsest level alone is read.
            reader.SetMaximumLevelsToReadByDefaultForAMR(0)
        else:
            reader.SetMaximumLevelsToReadByDefault(0)
        reader.Update()
        amr = reader.GetOutputDataObject(0)
        print(name)
        for level in range(amr.GetNumberOfLevels()):
            for number in range(amr.GetNumberOfDataSets(level)):
                image = amr.GetDataSetAsImageData(level, number)
                data = image.GetCellData() if name.startswith("cells") else image.GetPointData()
                values = vtk_to_numpy(data.GetArray("phi"))
                cells = [n - 1 for n in image.GetDimensions()]
                head = [level, *image.GetBounds()[::2], *image.GetSpacing(), *cells]
                print(*map(repr, [*map(float, head), *map(float, values)]))


def filled(image, kind, **sizes):
    for name, data, size in [("points", image.GetPointData(), sizes["points"]), ("cells", image.GetCellData(), sizes["cells"])]:
        array = numpy_to_vtk((numpy.arange(size) * 0.125).astype(kind), deep=True)
        array.SetName(name)
        data.AddArray(array)
    return image


def write(directory):
    modes = ["Ascii", "Binary", "Appended", "AppendedRaw", "Big"]
    compressors = [None, "ZLib", "LZ4"]
    for mode, compressor, header in itertools.product(modes, compressors, [32, 64]):
        image = vtkImageData()
        image.SetExtent(0, 4, 0, 3, 0, 2)
        image.SetOrigin(1, 2, 3)
        image.SetSpacing(0.5, 0.25, 2)
        filled(image, "f4" if header == 32 else "f8", points=60, cells=24)
        image.GetPointData().SetActiveScalars("points")
        name = f"{mode}_{compressor}_{header}"
        save(vtkXMLImageDataWriter(), image, mode, compressor, header, os.path.join(directory, name + ".vti"))
        print(name + ".vti")
        save(vtkXMLUniformGridAMRWriter(), amr(), mode, compressor, header, os.path.join(directory, name + ".vthb"))
        print(name + ".vthb")


def amr():
    data = vtkOverlappingAMR()
    data.Initialize([1, 1])
    data.SetOrigin([0.0, 0.0, 0.0])
    data.SetGridDescription(vtkStructuredData.VTK_STRUCTURED_XYZ_GRID)
    for level, low in [(0, 0), (1, 2)]:
        width = 0.5**level
        grid = vtkUniformGrid()
        grid.SetOrigin(*[low * width] * 3)
        grid.SetSpacing(*[width] * 3)
        grid.SetDimensions(5, 5, 5)
        array = numpy_to_vtk(numpy.arange(64, dtype="f8"), deep=True)
        array.SetName("phi")
        grid.GetCellData().AddArray(array)
        data.SetSpacing(level, [width] * 3)
        data.SetAMRBox(level, 0, vtkAMRBox([low] * 3, [low + 3] * 3))
        data.SetDataSet(level, 0, grid)
    vtkAMRUtilities.BlankCells(data)
    return data


def save(writer, data, mode, compressor, header, path):
    writer.SetFileName(path)
    writer.SetInputDataObject(data)
    if mode == "Ascii":
        writer.SetDataModeToAscii()
    elif mode == "Binary":
        writer.SetDataModeToBinary()
    else:
        writer.SetDataModeToAppended()
        writer.SetEncodeAppendedData(mode == "Appended")
    if mode == "Big":
        writer.SetByteOrderToBigEndian()
    {None: writer.SetCompressorTypeToNone, "ZLib": writer.SetCompressorTypeToZLib, "LZ4": writer.SetCompressorTypeToLZ4}[
        compressor
    ]()
    {32: writer.SetHeaderTypeToUInt32, 64: writer.SetHeaderTypeToUInt64}[header]()
    assert writer.Write()


{"read": read, "write": write}[sys.argv[1]](sys.argv[2])
