// What calls take and give. The structs are those of pocketnerf.h, field by field.
using System;
using System.Runtime.InteropServices;

namespace Pocketnerf
{
    /// The outcome of a call.
    public enum Status
    {
        Ok, Null, Misaligned, Argument, Camera, Buffer, File, NotAModel, Version, Damaged,
        Unsupported, NoSimd, Internal
    }

    /// What went wrong: a status, and one line about what was found and what was expected.
    public sealed class PocketnerfException : Exception
    {
        public Status Status { get; private set; }
        public PocketnerfException(Status status, string line) : base(line) { Status = status; }
    }

    [Flags]
    public enum OpenFlags : uint { None = 0, Unverified = 2, WithoutTable = 4, ModelCoordinates = 8 }

    /// How transparency is stored: over the background, multiplied by alpha, or not.
    public enum Alpha : uint { Background, Premultiplied, Straight }

    /// Along the ray, or along the camera's axis, as for a z-buffer.
    public enum DepthKind : uint { Distance, Z }

    /// What counts as the depth of a ray.
    public enum Depth : uint { Expected, Median, FirstSigma, FirstOpacity }

    public enum Text : uint { Name, Kind, Method, Program, Dataset }

    [StructLayout(LayoutKind.Sequential)]
    public struct Float2
    {
        public float X, Y;
        public Float2(float x, float y) { X = x; Y = y; }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Float3
    {
        public float X, Y, Z;
        public Float3(float x, float y, float z) { X = x; Y = y; Z = z; }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Ray { public Float3 Origin, Direction; }

    [StructLayout(LayoutKind.Sequential)]
    public struct Segment { public Float3 From, To; }

    [StructLayout(LayoutKind.Sequential)]
    public struct Ball { public Float3 Center; public float Radius; }

    [StructLayout(LayoutKind.Sequential)]
    public struct Radiance { public Float3 Rgb; public float Sigma; }

    /// What is under a pixel. Depth is infinite, the others zero, where there is nothing.
    [StructLayout(LayoutKind.Sequential)]
    public struct Hit { public float Depth; public Float3 Point, Normal; }

    [StructLayout(LayoutKind.Sequential)]
    public struct Stats { public ulong Rays, Samples, Hits; }

    /// A pinhole camera. Axes are OpenGL's: x right, y up, looking along -z. Right, Up, Back (unit
    /// vectors, right-handed) and Position are the columns of its camera-to-world matrix.
    [StructLayout(LayoutKind.Sequential)]
    public struct PinholeCamera
    {
        public uint Width, Height;
        /// Focal lengths and principal point, pixels.
        public Float2 Focal, Center;
        private float rightX, upX, backX, positionX;
        private float rightY, upY, backY, positionY;
        private float rightZ, upZ, backZ, positionZ;
        private float m30, m31, m32, m33;

        public Float3 Right
        {
            get { return new Float3(rightX, rightY, rightZ); }
            set { rightX = value.X; rightY = value.Y; rightZ = value.Z; }
        }
        public Float3 Up
        {
            get { return new Float3(upX, upY, upZ); }
            set { upX = value.X; upY = value.Y; upZ = value.Z; }
        }
        public Float3 Back
        {
            get { return new Float3(backX, backY, backZ); }
            set { backX = value.X; backY = value.Y; backZ = value.Z; }
        }
        public Float3 Position
        {
            get { return new Float3(positionX, positionY, positionZ); }
            set { positionX = value.X; positionY = value.Y; positionZ = value.Z; }
        }

        /// A camera at `eye` that looks at `target`; `fovX` is its horizontal field of view, radians.
        public static PinholeCamera LookAt(Float3 eye, Float3 target, Float3 up, float fovX,
            uint width, uint height)
        {
            var camera = new PinholeCamera();
            Native.Check(error => Native.pnrf_look_at(ref eye, ref target, ref up, fovX, width,
                height, out camera, error));
            return camera;
        }
    }

    /// Facts about a model: see PnrfInfo.
    [StructLayout(LayoutKind.Sequential)]
    public struct Info
    {
        public ulong Bytes, Parameters, TableBytes;
        public float Occupancy;
        public Float3 Center;
        public float Radius;
        public Float3 BoxMin, BoxMax;
        public float Scale;
        public Float3 RotationRow0, RotationRow1, RotationRow2;
        public Float3 Translation;
        public float Step;
        public Float3 Background;
        private uint isLinear, hasQueries, hasCamera;
        public float Quality;

        public bool IsLinear { get { return isLinear != 0; } }
        public bool HasQueries { get { return hasQueries != 0; } }
        public bool HasCamera { get { return hasCamera != 0; } }
    }

    /// How pictures and queries are computed.
    public sealed class Options
    {
        /// From 0, the fastest, to 1, the finest; below 0: as the file says, usually 0.5.
        public float Quality = -1;
        /// Some tens of kilobytes a worker instead of a megabyte; slower.
        public bool SmallMemory;

        internal NativeOptions Native
        {
            get
            {
                return new NativeOptions { Memory = SmallMemory ? 1u : 0u, Quality = Quality };
            }
        }
    }

    /// Where a whole picture goes: arrays of the caller's, four values a pixel, rows without gaps.
    public sealed class Target
    {
        /// Red, green, blue and alpha in bytes; or null.
        public byte[] Pixels;
        /// The same in numbers, in the model's own colour space, instead of bytes; or null.
        public float[] Floats;
        /// Distances, infinite where there is nothing; or null.
        public float[] Depth;
        public DepthKind DepthKind;
        public Alpha Alpha;
        /// For Alpha.Background, in the model's own colour space.
        public Float3 Background;
        /// Blue, green, red and alpha, for bytes.
        public bool IsBgra;
        /// Rows from bottom to top, as in textures of Unity and OpenGL.
        public bool IsBottomUp;
    }
}
