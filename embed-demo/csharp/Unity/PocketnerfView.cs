// Shows a radiance field in Unity, behind and in front of polygons. Add it to a camera of the
// built-in render pipeline; put pocketnerf_c into Assets/Plugins, and the model into Assets with the
// ending .pnerf.bytes.
//
// A worker renders one picture after another, while frames go on: each is shown with the colours and
// depths of the last picture, so that a moving camera is followed a picture later.
using System;
using System.Threading;
using System.Threading.Tasks;
using UnityEngine;
using Pocketnerf;
using Camera = UnityEngine.Camera;

[RequireComponent(typeof(Camera))]
public sealed class PocketnerfView : MonoBehaviour
{
    public TextAsset model;
    /// Pocketnerf/Composite.
    public Shader composite;
    /// Where the dataset's origin is, how it is turned, and how large a unit of it is (uniformly).
    public Transform place;
    /// Pixels of the picture for each of the screen's, along a side.
    [Range(0.05f, 1)] public float resolution = 0.5f;
    /// From 0, the fastest, to 1, the finest.
    [Range(0, 1)] public float quality = 0.25f;

    private Model scene;
    private Material material;
    private Texture2D colors, depths;
    private Shot shot;
    private CancellationTokenSource ending;

    /// A picture under way.
    private sealed class Shot
    {
        public PinholeCamera Camera;
        /// Unity's units for each of the dataset's.
        public float Scale;
        public byte[] Pixels;
        public float[] Depths;
        public Task Work;
    }

    private void OnEnable()
    {
        scene = Model.Open(model.bytes);
        material = new Material(composite);
        ending = new CancellationTokenSource();
        // What polygons are compared with.
        GetComponent<Camera>().depthTextureMode |= DepthTextureMode.Depth;
    }

    private void OnDisable()
    {
        if (ending == null) return;
        ending.Cancel();
        try { if (shot != null) shot.Work.Wait(); }
        catch (AggregateException) { /* It was cancelled, or has failed and nobody waits for it. */ }
        if (scene != null) scene.Dispose();
        Destroy(material);
        Destroy(colors);
        Destroy(depths);
        ending = null;
        shot = null;
        scene = null;
        material = null;
        colors = depths = null;
    }

    private void Update()
    {
        if (scene == null || (shot != null && !shot.Work.IsCompleted)) return;
        if (shot != null && shot.Work.IsFaulted)
        {
            Debug.LogException(shot.Work.Exception.GetBaseException());
            enabled = false;
            return;
        }
        var last = shot;
        if (last != null) Show(last);
        var camera = GetComponent<Camera>();
        var width = Math.Max(1, (int)(camera.pixelWidth * resolution));
        var height = Math.Max(1, (int)(camera.pixelHeight * resolution));
        var toDataset = place ? place.worldToLocalMatrix : Matrix4x4.identity;
        shot = Begin(new Shot
        {
            Camera = ToPocketnerf(toDataset * camera.transform.localToWorldMatrix,
                camera.fieldOfView, width, height),
            Scale = place ? place.lossyScale.x : 1,
            // The arrays of the last picture, where they fit.
            Pixels = last != null && last.Pixels.Length == 4 * width * height ? last.Pixels
                : new byte[4 * width * height],
            Depths = last != null && last.Depths.Length == width * height ? last.Depths
                : new float[width * height],
        });
    }

    private Shot Begin(Shot begun)
    {
        var target = new Target
        {
            Pixels = begun.Pixels,
            Alpha = Alpha.Premultiplied,
            Depth = begun.Depths,
            DepthKind = DepthKind.Z,
            // As Unity's textures.
            IsBottomUp = true,
        };
        var options = new Options { Quality = quality };
        var open = scene;
        var cancel = ending.Token;
        // A core is left to Unity.
        var threads = Math.Max(1, Environment.ProcessorCount - 1);
        begun.Work = Task.Run(() => open.Render(begun.Camera, target, options, threads, cancel), cancel);
        return begun;
    }

    private void Show(Shot done)
    {
        int width = (int)done.Camera.Width, height = (int)done.Camera.Height;
        if (colors == null || colors.width != width || colors.height != height)
        {
            Destroy(colors);
            Destroy(depths);
            colors = new Texture2D(width, height, TextureFormat.RGBA32, false);
            depths = new Texture2D(width, height, TextureFormat.RFloat, false, true);
            // Depths of two surfaces have no mean.
            depths.filterMode = FilterMode.Point;
        }
        colors.SetPixelData(done.Pixels, 0);
        colors.Apply(false);
        depths.SetPixelData(done.Depths, 0);
        depths.Apply(false);
        material.SetTexture("_FieldColor", colors);
        material.SetTexture("_FieldDepth", depths);
        material.SetFloat("_FieldScale", done.Scale);
    }

    private void OnRenderImage(RenderTexture polygons, RenderTexture screen)
    {
        if (colors == null) Graphics.Blit(polygons, screen);
        else Graphics.Blit(polygons, screen, material);
    }

    /// Hands a camera over. Unity's world is left-handed with y up, and its cameras look along +z;
    /// datasets are right-handed, here with z up, and cameras have the columns right, up, back.
    /// Exchanging y and z turns one world into the other (W in docs/embedding.md), and a camera's
    /// back is its negated forward (C). So right, up and back come out right-handed again.
    public static PinholeCamera ToPocketnerf(Matrix4x4 cameraToWorld, float verticalFov, int width,
        int height)
    {
        Func<Vector4, Float3> direction = v =>
        {
            // The place of the dataset may be scaled.
            var length = (float)Math.Sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
            return new Float3(v.x / length, v.z / length, v.y / length);
        };
        var forward = direction(cameraToWorld.GetColumn(2));
        var position = cameraToWorld.GetColumn(3);
        var focal = (float)(0.5 * height / Math.Tan(0.5 * verticalFov * Math.PI / 180));
        return new PinholeCamera
        {
            Width = (uint)width,
            Height = (uint)height,
            Focal = new Float2(focal, focal),
            Center = new Float2(0.5f * width, 0.5f * height),
            Right = direction(cameraToWorld.GetColumn(0)),
            Up = direction(cameraToWorld.GetColumn(1)),
            Back = new Float3(-forward.X, -forward.Y, -forward.Z),
            Position = new Float3(position.x, position.z, position.y),
        };
    }
}
