// The calls of pocketnerf.h, as they are there.
using System;
using System.Runtime.InteropServices;
using System.Text;

namespace Pocketnerf
{
    /// An open model: closed once, when nobody uses it any more.
    internal sealed class ModelHandle : SafeHandle
    {
        private ModelHandle() : base(IntPtr.Zero, true) { }
        public override bool IsInvalid { get { return handle == IntPtr.Zero; } }
        protected override bool ReleaseHandle()
        {
            Native.pnrf_close(handle);
            return true;
        }
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeOptions
    {
        public uint Simd, Sampling, Memory;
        public float Quality;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeImage
    {
        public IntPtr Pixels;
        public UIntPtr Size, Stride;
        public uint Format, Alpha;
        public Float3 Background;
        public uint BottomUp;
        public IntPtr Depth;
        public UIntPtr DepthSize, DepthStride;
        public uint DepthKind;
    }

    /// Arrays are pinned during a call. An error is 256 bytes: a status, and a line of text.
    internal static class Native
    {
        /// The version of pocketnerf.h that this file is made for.
        public const uint AbiVersion = 65538;
        private const int ErrorBytes = 256;

#if UNITY_IOS && !UNITY_EDITOR
        private const string Library = "__Internal";
#else
        private const string Library = "pocketnerf_c";
#endif

        [DllImport(Library)] public static extern uint pnrf_abi_version();
        [DllImport(Library)] public static extern int pnrf_open_file(byte[] path, uint flags,
            out ModelHandle model, byte[] error);
        [DllImport(Library)] public static extern int pnrf_open_bytes(byte[] bytes, UIntPtr length,
            uint flags, out ModelHandle model, byte[] error);
        [DllImport(Library)] public static extern void pnrf_close(IntPtr model);
        [DllImport(Library)] public static extern int pnrf_info(ModelHandle model, out Info info,
            byte[] error);
        [DllImport(Library)] public static extern int pnrf_text(ModelHandle model, uint which,
            byte[] buffer, UIntPtr capacity, out UIntPtr length, byte[] error);
        [DllImport(Library)] public static extern int pnrf_scratch_length(ModelHandle model,
            ref NativeOptions options, out UIntPtr length, byte[] error);

        [DllImport(Library)] public static extern int pnrf_default_camera(ModelHandle model,
            uint width, uint height, out PinholeCamera camera, byte[] error);
        [DllImport(Library)] public static extern int pnrf_orbit_camera(ModelHandle model,
            float azimuth, float elevation, float distance, ref Float3 up, uint width, uint height,
            out PinholeCamera camera, byte[] error);
        [DllImport(Library)] public static extern int pnrf_world(ModelHandle model, out Float3 up,
            out float metres, byte[] error);
        [DllImport(Library)] public static extern uint pnrf_photograph_count(ModelHandle model);
        [DllImport(Library)] public static extern int pnrf_photograph_camera(ModelHandle model,
            uint number, uint width, uint height, out PinholeCamera camera, byte[] error);
        [DllImport(Library)] public static extern int pnrf_look_at(ref Float3 eye,
            ref Float3 target, ref Float3 up, float fovX, uint width, uint height,
            out PinholeCamera camera, byte[] error);

        [DllImport(Library)] public static extern uint pnrf_tile_count(uint width, uint height,
            ref NativeOptions options);
        [DllImport(Library)] public static extern int pnrf_render_tile(ModelHandle model,
            ref PinholeCamera camera, ref NativeOptions options, uint number, ref NativeImage image,
            float[] scratch, UIntPtr scratchLength, out Stats stats, byte[] error);

        [DllImport(Library)] public static extern int pnrf_pick(ModelHandle model,
            ref NativeOptions options, ref PinholeCamera camera, Float2[] pixels, UIntPtr n,
            [Out] Hit[] hits, float[] scratch, UIntPtr scratchLength, byte[] error);
        [DllImport(Library)] public static extern int pnrf_depths(ModelHandle model,
            ref NativeOptions options, Ray[] rays, UIntPtr n, uint kind, float threshold,
            IntPtr axis, [Out] float[] depths, float[] scratch, UIntPtr scratchLength,
            byte[] error);
        [DllImport(Library)] public static extern int pnrf_density(ModelHandle model,
            ref NativeOptions options, Float3[] points, UIntPtr n, [Out] float[] sigma,
            float[] scratch, UIntPtr scratchLength, byte[] error);
        [DllImport(Library)] public static extern int pnrf_radiance(ModelHandle model,
            ref NativeOptions options, Float3[] points, Float3[] directions, UIntPtr n,
            [Out] Radiance[] answers, float[] scratch, UIntPtr scratchLength, byte[] error);
        [DllImport(Library)] public static extern int pnrf_normals(ModelHandle model,
            ref NativeOptions options, Float3[] points, UIntPtr n, [Out] Float3[] normals,
            float[] scratch, UIntPtr scratchLength, byte[] error);
        [DllImport(Library)] public static extern int pnrf_segment_transmittance(ModelHandle model,
            ref NativeOptions options, Segment[] segments, UIntPtr n, [Out] float[] passes,
            float[] scratch, UIntPtr scratchLength, byte[] error);
        [DllImport(Library)] public static extern int pnrf_sphere_clear(ModelHandle model,
            Ball[] balls, UIntPtr n, [Out] byte[] clear, byte[] error);

        /// Makes a call, and an exception of its failure.
        public static void Check(Func<byte[], int> call)
        {
            var error = new byte[ErrorBytes];
            var status = call(error);
            if (status == 0) return;
            var end = Array.IndexOf(error, (byte)0, 4);
            var line = Encoding.UTF8.GetString(error, 4, (end < 0 ? ErrorBytes : end) - 4);
            throw new PocketnerfException((Status)status, line);
        }

        public static UIntPtr Length(Array list)
        {
            return (UIntPtr)(ulong)list.Length;
        }
    }
}
