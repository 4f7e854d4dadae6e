// The few types of UnityEngine that PocketnerfView uses, so that it compiles and runs without Unity.
// Textures and materials keep what they are given.
using System;
using System.Collections.Generic;

namespace UnityEngine
{
    [AttributeUsage(AttributeTargets.Class)]
    public sealed class RequireComponent : Attribute { public RequireComponent(Type type) { } }

    [AttributeUsage(AttributeTargets.Field)]
    public sealed class RangeAttribute : Attribute { public RangeAttribute(float least, float most) { } }

    public class Object
    {
        public static int Destroyed;
        public static void Destroy(Object which) { if (which != null) Destroyed++; }
        public static implicit operator bool(Object which) { return which != null; }
    }

    public class Component : Object
    {
        public Dictionary<Type, object> Siblings = new Dictionary<Type, object>();
        public T GetComponent<T>() { return (T)Siblings[typeof(T)]; }
    }

    public class MonoBehaviour : Component { public bool enabled = true; }

    public struct Vector3 { public float x, y, z; }
    public struct Vector4 { public float x, y, z, w; }

    /// Of columns.
    public struct Matrix4x4
    {
        public float[] Rows;
        public static Matrix4x4 identity
        {
            get { return new Matrix4x4 { Rows = new float[] { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 } }; }
        }
        public Vector4 GetColumn(int c)
        {
            return new Vector4 { x = Rows[c], y = Rows[4 + c], z = Rows[8 + c], w = Rows[12 + c] };
        }
        public static Matrix4x4 operator *(Matrix4x4 a, Matrix4x4 b)
        {
            var rows = new float[16];
            for (var i = 0; i < 64; i++) rows[i / 4] += a.Rows[i / 16 * 4 + i % 4] * b.Rows[i % 4 * 4 + i / 4 % 4];
            return new Matrix4x4 { Rows = rows };
        }
    }

    public sealed class Transform : Component
    {
        public Matrix4x4 localToWorldMatrix = Matrix4x4.identity, worldToLocalMatrix = Matrix4x4.identity;
        public Vector3 lossyScale = new Vector3 { x = 1, y = 1, z = 1 };
    }

    [Flags] public enum DepthTextureMode { None, Depth }

    public sealed class Camera : Component
    {
        public DepthTextureMode depthTextureMode;
        public int pixelWidth, pixelHeight;
        public float fieldOfView;
        public Transform transform = new Transform();
    }

    public sealed class TextAsset : Object { public byte[] bytes; }
    public sealed class Shader : Object { }
    public enum TextureFormat { RGBA32, RFloat }
    public enum FilterMode { Point, Bilinear }
    public class Texture : Object { public int width, height; public FilterMode filterMode; }
    public sealed class RenderTexture : Texture { }

    public sealed class Texture2D : Texture
    {
        public Array Given, Applied;
        public Texture2D(int width, int height, TextureFormat format, bool mips, bool linear = false)
        {
            this.width = width;
            this.height = height;
        }
        public void SetPixelData<T>(T[] data, int mip) { Given = (T[])data.Clone(); }
        public void Apply(bool mips) { Applied = Given; }
    }

    public sealed class Material : Object
    {
        public Dictionary<string, object> Values = new Dictionary<string, object>();
        public Material(Shader shader) { }
        public void SetTexture(string name, Texture value) { Values[name] = value; }
        public void SetFloat(string name, float value) { Values[name] = value; }
    }

    public static class Graphics
    {
        public static Material Last;
        public static void Blit(Texture from, RenderTexture to) { Last = null; }
        public static void Blit(Texture from, RenderTexture to, Material material) { Last = material; }
    }

    public static class Debug
    {
        public static Exception Logged;
        public static void LogException(Exception error) { Logged = error; }
    }
}
