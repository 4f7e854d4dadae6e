// pocketnerf for .NET and Unity: radiance fields from .pnerf files, on the CPU, through the C library
// pocketnerf_c (libpocketnerf_c.so, pocketnerf_c.dll). Failures are exceptions with one line.
//
// A Model never changes and may be used by any number of threads. A Worker has the memory that one
// thread needs for tiles and queries.
using System;
using System.Runtime.ExceptionServices;
using System.Runtime.InteropServices;
using System.Text;
using System.Threading;
using System.Threading.Tasks;

namespace Pocketnerf
{
    /// An open model, until it is disposed of. Calls that are under way then still end as usual.
    public sealed class Model : IDisposable
    {
        internal readonly ModelHandle Handle;

        private Model(ModelHandle handle) { Handle = handle; }

        public static Model Open(string path, OpenFlags flags = OpenFlags.None)
        {
            if (path == null) throw new ArgumentNullException("path");
            var name = Encoding.UTF8.GetBytes(path + "\0");
            return Opened((out ModelHandle model, byte[] error) =>
                Native.pnrf_open_file(name, (uint)flags, out model, error));
        }

        /// Opens a model in memory, which is copied.
        public static Model Open(byte[] bytes, OpenFlags flags = OpenFlags.None)
        {
            if (bytes == null) throw new ArgumentNullException("bytes");
            return Opened((out ModelHandle model, byte[] error) =>
                Native.pnrf_open_bytes(bytes, Native.Length(bytes), (uint)flags, out model, error));
        }

        private delegate int Opening(out ModelHandle model, byte[] error);

        private static Model Opened(Opening open)
        {
            var found = Native.pnrf_abi_version();
            if (found >> 16 != Native.AbiVersion >> 16 || found < Native.AbiVersion)
                throw new PocketnerfException(Status.Version, string.Format(
                    "pocketnerf_c has interface {0}.{1}, expected {2}.{3} or later", found >> 16,
                    found & 0xffff, Native.AbiVersion >> 16, Native.AbiVersion & 0xffff));
            ModelHandle handle = null;
            Native.Check(error => open(out handle, error));
            return new Model(handle);
        }

        public void Dispose() { Handle.Dispose(); }

        public Info Info
        {
            get
            {
                var info = new Info();
                Native.Check(error => Native.pnrf_info(Handle, out info, error));
                return info;
            }
        }

        /// A fact in words; empty if the file does not say.
        public string Text(Text which)
        {
            UIntPtr length;
            Native.pnrf_text(Handle, (uint)which, null, UIntPtr.Zero, out length, null);
            var text = new byte[(int)length];
            Native.Check(error => Native.pnrf_text(Handle, (uint)which, text, length, out length,
                error));
            return Encoding.UTF8.GetString(text, 0, text.Length - 1);
        }

        /// The file's own view, or one beside the scene; 0x0: of the file's own size.
        public PinholeCamera Camera(uint width = 0, uint height = 0)
        {
            var camera = new PinholeCamera();
            Native.Check(error => Native.pnrf_default_camera(Handle, width, height, out camera,
                error));
            return camera;
        }

        /// A camera that goes around the centre: angles in radians about `up`, z unless given;
        /// distance 0: as far away as the file's own.
        public PinholeCamera Orbit(float azimuth, float elevation, float distance = 0,
            Float3? up = null, uint width = 0, uint height = 0)
        {
            var camera = new PinholeCamera();
            var axis = up ?? Up;
            Native.Check(error => Native.pnrf_orbit_camera(Handle, azimuth, elevation, distance,
                ref axis, width, height, out camera, error));
            return camera;
        }

        /// What is up, a unit vector: z where the file says nothing.
        public Float3 Up
        {
            get
            {
                float metres;
                return World(out metres);
            }
        }

        /// How long the unit of coordinates is; 0 where the file says nothing.
        public float MetresPerUnit
        {
            get
            {
                float metres;
                World(out metres);
                return metres;
            }
        }

        Float3 World(out float metresPerUnit)
        {
            var up = new Float3();
            var metres = 0f;
            Native.Check(error => Native.pnrf_world(Handle, out up, out metres, error));
            metresPerUnit = metres;
            return up;
        }

        /// How many photographs' cameras the file has.
        public uint PhotographCount { get { return Native.pnrf_photograph_count(Handle); } }

        public PinholeCamera Photograph(uint number, uint width = 0, uint height = 0)
        {
            var camera = new PinholeCamera();
            Native.Check(error => Native.pnrf_photograph_camera(Handle, number, width, height,
                out camera, error));
            return camera;
        }

        /// Whether balls are certainly free.
        public bool[] Clear(Ball[] balls)
        {
            var clear = new byte[balls.Length];
            Native.Check(error => Native.pnrf_sphere_clear(Handle, balls, Native.Length(balls),
                clear, error));
            return Array.ConvertAll(clear, free => free != 0);
        }

        /// Renders a picture on the thread pool, at most `threads` at a time; 0: as many as there
        /// are cores. The bytes do not depend on their number. Cancelling throws
        /// OperationCanceledException between tiles.
        public Stats Render(PinholeCamera camera, Target target, Options options = null,
            int threads = 0, CancellationToken cancel = default(CancellationToken))
        {
            var native = (options ?? new Options()).Native;
            // A camera without tiles is refused by the first call.
            var n = Math.Max((int)Native.pnrf_tile_count(camera.Width, camera.Height, ref native), 1);
            var most = threads > 0 ? threads : Environment.ProcessorCount;
            var how = new ParallelOptions { MaxDegreeOfParallelism = most, CancellationToken = cancel };
            var sum = new Stats();
            var pinned = new PinnedImage(target);
            try
            {
                Parallel.For(0, n, how, () => new Worker(this, options), (tile, state, worker) =>
                {
                    worker.Add(camera, (uint)tile, ref pinned.Image);
                    return worker;
                }, worker =>
                {
                    lock (how)
                    {
                        sum.Rays += worker.Sum.Rays;
                        sum.Samples += worker.Sum.Samples;
                        sum.Hits += worker.Sum.Hits;
                    }
                });
            }
            catch (AggregateException all)
            {
                ExceptionDispatchInfo.Capture(all.Flatten().InnerExceptions[0]).Throw();
            }
            finally
            {
                pinned.Dispose();
            }
            return sum;
        }
    }

    /// What one thread renders tiles and asks with. It needs its model open.
    public sealed class Worker
    {
        private readonly Model model;
        private readonly float[] scratch;
        private NativeOptions options;
        /// Of the tiles that a picture had rendered with it.
        internal Stats Sum;

        public Worker(Model model, Options options = null)
        {
            this.model = model;
            this.options = (options ?? new Options()).Native;
            UIntPtr length = UIntPtr.Zero;
            Native.Check(error => Native.pnrf_scratch_length(model.Handle, ref this.options,
                out length, error));
            scratch = new float[(int)length];
        }

        public uint TileCount(PinholeCamera camera)
        {
            return Native.pnrf_tile_count(camera.Width, camera.Height, ref options);
        }

        /// Renders one tile, `number` from 0 to TileCount - 1, into its place in the picture.
        public Stats RenderTile(PinholeCamera camera, uint number, Target target)
        {
            Sum = new Stats();
            var pinned = new PinnedImage(target);
            try { Add(camera, number, ref pinned.Image); }
            finally { pinned.Dispose(); }
            return Sum;
        }

        internal void Add(PinholeCamera camera, uint number, ref NativeImage image)
        {
            var stats = new Stats();
            var copy = image;
            Native.Check(error => Native.pnrf_render_tile(model.Handle, ref camera, ref options,
                number, ref copy, scratch, Native.Length(scratch), out stats, error));
            Sum.Rays += stats.Rays;
            Sum.Samples += stats.Samples;
            Sum.Hits += stats.Hits;
        }

        /// What is under a pixel; the centre of the upper left one is at (0.5, 0.5).
        public Hit Pick(PinholeCamera camera, float x, float y)
        {
            return Pick(camera, new[] { new Float2(x, y) })[0];
        }

        public Hit[] Pick(PinholeCamera camera, Float2[] pixels)
        {
            var hits = new Hit[pixels.Length];
            Native.Check(error => Native.pnrf_pick(model.Handle, ref options, ref camera, pixels,
                Native.Length(pixels), hits, scratch, Native.Length(scratch), error));
            return hits;
        }

        /// How far rays see; infinite where they see nothing of the kind.
        public float[] Depths(Ray[] rays, Depth kind = Depth.Median, float threshold = 0)
        {
            var depths = new float[rays.Length];
            Native.Check(error => Native.pnrf_depths(model.Handle, ref options, rays,
                Native.Length(rays), (uint)kind, threshold, IntPtr.Zero, depths, scratch,
                Native.Length(scratch), error));
            return depths;
        }

        /// Sigma: the fraction of light absorbed per length.
        public float[] Density(Float3[] points)
        {
            var sigma = new float[points.Length];
            Native.Check(error => Native.pnrf_density(model.Handle, ref options, points,
                Native.Length(points), sigma, scratch, Native.Length(scratch), error));
            return sigma;
        }

        /// Colours of points seen along directions, and sigma.
        public Radiance[] Radiance(Float3[] points, Float3[] directions)
        {
            if (points.Length != directions.Length)
                throw new ArgumentException(string.Format("{0} directions, expected {1}",
                    directions.Length, points.Length));
            var answers = new Radiance[points.Length];
            Native.Check(error => Native.pnrf_radiance(model.Handle, ref options, points,
                directions, Native.Length(points), answers, scratch, Native.Length(scratch), error));
            return answers;
        }

        /// Where surfaces face at points; zero where sigma has no gradient.
        public Float3[] Normals(Float3[] points)
        {
            var normals = new Float3[points.Length];
            Native.Check(error => Native.pnrf_normals(model.Handle, ref options, points,
                Native.Length(points), normals, scratch, Native.Length(scratch), error));
            return normals;
        }

        /// The light that passes between two points.
        public float[] Transmittance(Segment[] segments)
        {
            var passes = new float[segments.Length];
            Native.Check(error => Native.pnrf_segment_transmittance(model.Handle, ref options,
                segments, Native.Length(segments), passes, scratch, Native.Length(scratch), error));
            return passes;
        }
    }

    /// A target whose arrays stay in place while it is rendered.
    internal sealed class PinnedImage : IDisposable
    {
        public NativeImage Image;
        private GCHandle pixels, depth;

        public PinnedImage(Target target)
        {
            if (target == null) throw new ArgumentNullException("target");
            var bytes = (Array)target.Pixels ?? target.Floats;
            Image.Format = target.Pixels == null ? 2u : target.IsBgra ? 1u : 0u;
            Image.Alpha = (uint)target.Alpha;
            Image.Background = target.Background;
            Image.BottomUp = target.IsBottomUp ? 1u : 0u;
            Image.DepthKind = (uint)target.DepthKind;
            pixels = GCHandle.Alloc(bytes, GCHandleType.Pinned);
            depth = GCHandle.Alloc(target.Depth, GCHandleType.Pinned);
            Image.Pixels = bytes == null ? IntPtr.Zero : pixels.AddrOfPinnedObject();
            Image.Size = Size(bytes);
            Image.Depth = target.Depth == null ? IntPtr.Zero : depth.AddrOfPinnedObject();
            Image.DepthSize = Size(target.Depth);
        }

        private static UIntPtr Size(Array list)
        {
            return (UIntPtr)(ulong)(list == null ? 0 : Buffer.ByteLength(list));
        }

        public void Dispose()
        {
            pixels.Free();
            depth.Free();
        }
    }
}
