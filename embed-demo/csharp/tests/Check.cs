// What the wrapper and the view for Unity give, and what misuse is told:
// Check.exe MODEL.pnerf PHOTOGRAPHS.pnerf. Prints facts for the caller to compare.
using System;
using System.IO;
using System.Reflection;
using System.Threading;
using UnityEngine;
using Pocketnerf;
using Camera = UnityEngine.Camera;

internal static class Check
{
    private static int failures;

    private static void That(bool isSo, string what)
    {
        if (isSo) return;
        Console.Error.WriteLine("not so: " + what);
        failures++;
    }

    /// One line, with this in it.
    private static void Fails<E>(string part, Action call) where E : Exception
    {
        try { call(); }
        catch (E error)
        {
            var isLine = !(error is PocketnerfException) || !error.Message.Contains("\n");
            That(error.Message.Contains(part) && isLine, error.Message);
            return;
        }
        That(false, "an exception about " + part);
    }

    private static int Main(string[] arguments)
    {
        using (var model = Model.Open(arguments[0]))
        using (var photographs = Model.Open(File.ReadAllBytes(arguments[1])))
        {
            Facts(model);
            Pictures(model);
            Questions(model);
            That(photographs.PhotographCount == 3, "three photographs");
            That(photographs.Photograph(2, 8, 6).Width == 8, "the last photograph");
            Fails<PocketnerfException>("3 of 3", () => photographs.Photograph(3));
        }
        Misuse(arguments[0]);
        Handover();
        View(arguments[0]);
        return failures;
    }

    /// In the order of pocketnerf.h, to be compared with what C says.
    private static void Facts(Model model)
    {
        var info = model.Info;
        var camera = model.Camera(40, 30);
        Console.WriteLine(string.Join(" ", info.Bytes, info.Parameters, info.TableBytes,
            info.HasQueries, info.HasCamera, info.IsLinear, camera.Width, camera.Height));
        var numbers = new[]
        {
            info.Occupancy, info.Center.Z, info.Radius, info.BoxMin.X, info.BoxMax.Z, info.Scale,
            info.RotationRow2.Z, info.Translation.Z, info.Step, info.Background.X, info.Quality,
            camera.Focal.Y, camera.Center.X, camera.Right.Y, camera.Up.Z, camera.Back.X,
            camera.Position.X, camera.Position.Z,
        };
        Console.WriteLine(string.Join(" ", Array.ConvertAll(numbers,
            v => BitConverter.ToUInt32(BitConverter.GetBytes(v), 0).ToString("x8"))));
        That(model.Text(Text.Kind) == "hash-grid", "a kind");
        That(Is(model.Up, 0, 0, 1) && model.MetresPerUnit == 0, "a world of which nothing is said");
    }

    private static void Pictures(Model model)
    {
        var camera = model.Camera(150, 90);
        var all = new byte[4 * 150 * 90];
        var stats = model.Render(camera, new Target { Pixels = all });
        That(stats.Rays > 0 && stats.Samples > stats.Hits, "statistics");
        var one = new byte[all.Length];
        model.Render(camera, new Target { Pixels = one }, null, 1);
        var tiles = new byte[all.Length];
        var worker = new Worker(model);
        for (uint tile = 0; tile < worker.TileCount(camera); tile++)
            worker.RenderTile(camera, tile, new Target { Pixels = tiles, IsBgra = true });
        for (var i = 0; i < all.Length; i += 4)
        {
            if (all[i] == one[i] && all[i + 3] == 255 && all[i] == tiles[i + 2] && all[i + 1] == tiles[i + 1])
                continue;
            That(false, "the same picture, from byte " + i);
            break;
        }
        var depth = new float[150 * 90];
        model.Render(camera, new Target { Depth = depth });
        var hit = worker.Pick(camera, 75.5f, 70.5f);
        That(Math.Abs(depth[70 * 150 + 75] - hit.Depth) < 0.02f * hit.Depth, "the same depth");
        var floats = new float[all.Length];
        model.Render(camera, new Target { Floats = floats, Alpha = Alpha.Straight });
        That(Array.Exists(floats, v => v > 0.1f && v < 0.9f), "numbers");

        Fails<PocketnerfException>("room for", () => model.Render(camera, new Target { Pixels = new byte[7] }));
        Fails<PocketnerfException>("null", () => model.Render(camera, new Target()));
        Fails<PocketnerfException>("camera", () => model.Render(new PinholeCamera(), new Target { Pixels = all }));
        Fails<PocketnerfException>("quality", () =>
            model.Render(camera, new Target { Pixels = all }, new Options { Quality = float.NaN }));
        Fails<OperationCanceledException>("", () => model.Render(camera, new Target { Pixels = all }, null, 0,
            new CancellationToken(true)));
    }

    private static void Questions(Model model)
    {
        var worker = new Worker(model, new Options { SmallMemory = true });
        var centre = model.Info.Center;
        var points = new[] { centre, new Float3(900, 0, 0) };
        That(worker.Density(points)[1] == 0, "nothing is far away");
        That(worker.Normals(points)[1].Z == 0, "what is not there has no normal");
        That(worker.Radiance(points, points)[1].Sigma == 0, "nor a colour");
        That(worker.Transmittance(new[] { new Segment { From = points[1], To = points[1] } })[0] == 1, "light passes");
        var clear = model.Clear(new[] { new Ball { Center = points[1], Radius = 1 }, new Ball { Center = centre, Radius = 9 } });
        That(clear[0] && !clear[1], "free, and not free");
        var down = new Ray { Origin = new Float3(centre.X, centre.Y, centre.Z + 9), Direction = new Float3(0, 0, -1) };
        var depth = worker.Depths(new[] { down })[0];
        That(depth > 0 && depth < 12, "something below");
        Fails<PocketnerfException>("", () => worker.Density(new[] { new Float3(float.NaN, 0, 0) }));
        Fails<ArgumentException>("0 directions", () => worker.Radiance(points, new Float3[0]));
        Fails<PocketnerfException>("elevation", () => model.Orbit(0, 3));
        That(Math.Abs(model.Orbit(0, 0, 5).Position.X - centre.X - 5) < 1e-4f, "five units aside");
        Fails<PocketnerfException>("eye", () =>
            PinholeCamera.LookAt(new Float3(float.NaN, 0, 0), centre, new Float3(0, 0, 1), 1, 8, 6));
    }

    private static void Misuse(string path)
    {
        Fails<PocketnerfException>("/nowhere: ", () => Model.Open("/nowhere"));
        Fails<ArgumentNullException>("path", () => Model.Open((string)null));
        var bytes = File.ReadAllBytes(path);
        bytes[bytes.Length - 1] ^= 1;
        Fails<PocketnerfException>("", () => Model.Open(bytes));
        Fails<PocketnerfException>("", () => Model.Open(new byte[0]));
        var model = Model.Open(path);
        var camera = model.Camera(8, 6);
        var worker = new Worker(model);
        model.Dispose();
        model.Dispose();
        var target = new Target { Pixels = new byte[4 * 8 * 6] };
        Fails<ObjectDisposedException>("", () => Console.WriteLine(model.Info));
        Fails<ObjectDisposedException>("", () => model.Render(camera, target));
        Fails<ObjectDisposedException>("", () => worker.RenderTile(camera, 0, target));
        Fails<ObjectDisposedException>("", () => worker.Pick(camera, 1, 1));
    }

    private static bool Is(Float3 found, float x, float y, float z)
    {
        return Math.Abs(found.X - x) + Math.Abs(found.Y - y) + Math.Abs(found.Z - z) < 1e-5f;
    }

    /// At (1, 2, 3) in Unity, where y is up: right is +x, forward +z.
    private static void Handover()
    {
        var pose = new Matrix4x4 { Rows = new float[] { 2, 0, 0, 1, 0, 2, 0, 2, 0, 0, 2, 3, 0, 0, 0, 1 } };
        var camera = PocketnerfView.ToPocketnerf(pose, 90, 40, 30);
        That(Is(camera.Right, 1, 0, 0) && Is(camera.Up, 0, 0, 1) && Is(camera.Back, 0, -1, 0), "axes");
        That(Is(camera.Position, 1, 3, 2), "a position");
        That(Math.Abs(camera.Focal.X - 15) < 1e-4f && camera.Width == 40, "a quarter turn over 30 pixels");
    }

    private static void Send(PocketnerfView view, string message)
    {
        var method = typeof(PocketnerfView).GetMethod(message, BindingFlags.Instance | BindingFlags.NonPublic);
        method.Invoke(view, message == "OnRenderImage" ? new object[] { null, null } : null);
    }

    /// What Unity does with the view: a picture arrives in its textures.
    private static void View(string path)
    {
        PinholeCamera own;
        var expected = new byte[4 * 40 * 30];
        var z = new float[40 * 30];
        using (var model = Model.Open(path))
        {
            own = model.Camera(40, 30);
            // A quarter turn from top to bottom.
            own.Focal = new Float2(15, 15);
            model.Render(own, new Target
            {
                Pixels = expected, Depth = z, Alpha = Alpha.Premultiplied, DepthKind = DepthKind.Z, IsBottomUp = true,
            }, new Options { Quality = 0.25f });
        }
        // The same camera in Unity's world: y and z exchanged, forward instead of back.
        var rows = new[]
        {
            own.Right.X, own.Up.X, -own.Back.X, own.Position.X,
            own.Right.Z, own.Up.Z, -own.Back.Z, own.Position.Z,
            own.Right.Y, own.Up.Y, -own.Back.Y, own.Position.Y, 0, 0, 0, 1,
        };
        var camera = new Camera { pixelWidth = 80, pixelHeight = 60, fieldOfView = 90 };
        camera.transform.localToWorldMatrix = new Matrix4x4 { Rows = rows };
        var view = new PocketnerfView { model = new TextAsset { bytes = File.ReadAllBytes(path) }, composite = new Shader() };
        view.Siblings[typeof(Camera)] = camera;
        Send(view, "OnEnable");
        That(camera.depthTextureMode == DepthTextureMode.Depth, "polygons' depths");
        for (var i = 0; i < 3000 && Graphics.Last == null; i++)
        {
            Send(view, "Update");
            Send(view, "OnRenderImage");
            Thread.Sleep(10);
        }
        That(Graphics.Last != null && Debug.Logged == null, "a picture");
        var colors = (Texture2D)Graphics.Last.Values["_FieldColor"];
        var depths = (Texture2D)Graphics.Last.Values["_FieldDepth"];
        var off = 0;
        for (var i = 0; i < expected.Length; i++)
            off = Math.Max(off, Math.Abs(expected[i] - ((byte[])colors.Applied)[i]));
        That(colors.width == 40 && off <= 2, "the same colours");
        var far = 0f;
        for (var i = 0; i < z.Length; i++)
            if (z[i] != ((float[])depths.Applied)[i])
                far = Math.Max(far, Math.Abs(z[i] - ((float[])depths.Applied)[i]));
        That(far < 1e-2f && Array.Exists(z, v => !float.IsInfinity(v)), "the same depths");
        Send(view, "OnDisable");
        Send(view, "OnDisable");
        That(UnityEngine.Object.Destroyed == 3, "nothing is left");
    }
}
